"""Shows what the library makes: one object or material a picture, in a studio, the ordinary way.

`exhibits` chooses, `studio` composes and arranges them, `sheet` renders and tiles the pictures;
`materialsheet` does the same for materials, on balls.

``photograph`` renders what stands in the studio.
"""

from openrooms_usd.showroom.exhibits import Exhibit, exhibits
from openrooms_usd.showroom.materialsheet import draw_material_sheets
from openrooms_usd.showroom.sheet import draw_sheet

__all__ = ["Exhibit", "draw_material_sheets", "draw_sheet", "exhibits"]
