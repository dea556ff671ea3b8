"""What several categories are built of.

`pieces` has what builders make, `boards` boards, legs and posts; `assembly` puts parts together
with their joints, `posing` turns them. Carcasses: `carcass`, `cells`, `fronts` (doors and drawers),
`kitchen`, `small_table`. Machines: `appliance`, `cooker`, `laundry`, `screen`, `computing`,
`handheld`, `lamp_parts`. Vessels and water: `vessel`, `basin`. Soft: `cloth`, `linens`. Plants:
`foliage`. What is printed and read: `books`, `prints`, `paintings`, `posters`. What hangs flat on
walls: `wall_board`.
"""
