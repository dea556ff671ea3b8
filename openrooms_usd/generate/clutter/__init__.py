"""What lies about: small things on the surfaces of a furnished room, as people leave them.

- `levels`, `spots`: the level tops and boards of furniture, by what they are used for;
- `amounts`, `making`: how much lies where, and of which makes;
- `laying`, `resting`, `scatter`: where it lies, on tops, in stacks and rows;
- `living`: all of it, level by level.
"""
