"""The rules of ``orusd validate``: USD's own validators, and ours about layers and about prims.

`model`: a stage as rules see it, `roomview`: a room as people see it; `core`: USD's own validators;
`layer_rules`, `prim_rules`, `physics_rules`, `physx_rules`, `room_rules`: ours; `licences`: of
what people bring.
"""
