"""The steps: each reads the composed stage below it and writes one layer.

- `base`, `runner`, `draft`, `reports`: the contract, what runs one, where its layer waits;
- `checks`: what cannot be made, found before any of them runs;
- `captures`: the capture of a section, which several of them read;
- `layout`, `alignment`, `materials`, `lights`, `cameras`, `physics`: a package for each step.
"""
