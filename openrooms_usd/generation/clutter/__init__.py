"""What lies about: small things on the surfaces of a furnished room, as people leave them.

- `levels`, `resting`, `forms`: level tops and boards of furniture, and its upper sides;
- `spots`, `sills`, `amounts`, `making`: what surfaces are used for, how much lies there, of which
  makes;
- `laying`, `scatter`: where it lies, on tops and boards, in stacks and rows. `soft`: on seats and
beds. `draping`, `hooks`, `hanging`: over edges, on hooks and rails. `settling`: in bowls and bins.
`ground`: on the floor and the walls. `arrangements`: laid tables; - `living`: all of it, level by
level; `described`: in a room from a description.
"""
