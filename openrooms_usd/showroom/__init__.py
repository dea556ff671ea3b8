"""Shows what the library makes: one object a picture, in a studio, the ordinary way.

`exhibits` chooses, `studio` composes and arranges them, `sheet` renders and tiles the pictures.
"""

from openrooms_usd.showroom.exhibits import Exhibit, exhibits
from openrooms_usd.showroom.sheet import draw_sheet

__all__ = ["Exhibit", "draw_sheet", "exhibits"]
