"""Broken and hostile input for every command that reads some: ``python -m tests.fuzz``.

- `kinds`: what a kind of input is; `captures`, `clouds`, `models`, `materials`, `stages`,
  `renders`, `targets`: all that there are; `planted`: some that go wrong on purpose;
- `spoiling` with `bytewise`, `structure` and `containers`: how input is spoilt;
- `case`: one case in this process; `running`: many in others; `__main__`: what they gave.
"""
