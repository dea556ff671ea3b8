"""CADs put where a scan shows furniture: which one, where, how turned and how large.

In the order of the work:

- `hints`: what is known before; `evidence`, `selection`: the points of one object;
- `retrieval`: CADs that are alike; `template`: one of them with its seven parameters;
- `wallsides`, `undersides`, `surroundings`, `truesize`: what else speaks for a pose;
- `hypotheses`: where fits begin; `priors`, `discs`, `fitting`: one fit;
- `competition`: hypotheses against each other; `alignment`: all objects of a scan.
"""
