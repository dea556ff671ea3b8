"""How near pictures of our rooms are to photographs, in numbers that need no trained network.

`features`: one picture as numbers. `views`: what finished renders show. `published`: what is known
of photographs of rooms. `report`: all of it side by side.
"""
