"""The rules of ``orusd validate``: USD's own validators, and ours about layers and about prims.

`model`: a stage as rules see it, `roomview`: a room as people see it, `carrying`:
what carries a thing; `stage_rules`: USD's own
validators, and ours with `physx_rules` and `room_rules`; `licences`: of
what people bring.
"""
