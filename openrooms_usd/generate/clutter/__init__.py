"""What lies about: small things on the surfaces of a furnished room, as people leave them.

- `levels`, `resting`: level tops and boards of furniture, and its upper sides;
- `spots`, `amounts`: what surfaces are used for, and how much lies there;
- `laying`, `scatter`: of which makes and where it lies, on tops and boards, in stacks and rows;
  `soft`: on seats and beds; `draping`, `hooks`: over edges, on hooks and rails; `settling`: in
  bowls and bins; `ground`: on the floor and the walls; `arrangements`: laid tables;
- `living`: all of it, sills too, level by level; `described`: in a room that people described.
"""
