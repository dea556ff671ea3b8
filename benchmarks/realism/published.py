"""What is published of photographs of rooms, with its source."""

from typing import Final

# Share of labelled pixels by class of NYU Depth V2's 1,449 pictures (Silberman et al., ECCV 2012),
# per cent: one over the class weights that RGB-D segmenters publish for it (hundredth over weight).
# They are the percentages of Gupta, Arbelaez and Malik (CVPR 2013) to the last digit that these
# print.
NYU40_PER_CENT: Final[dict[str, float]] = {
    "wall": 21.6, "floor": 9.2, "cabinet": 6.6, "bed": 3.5, "chair": 3.4, "sofa": 2.4, "table": 2.0,
    "door": 2.0, "window": 2.2, "bookshelf": 1.9, "picture": 2.0, "counter": 1.3, "blinds": 1.6,
    "desk": 1.0, "shelves": 1.2, "curtain": 1.0, "dresser": 0.9, "pillow": 0.8, "mirror": 1.1,
    "floor_mat": 0.6, "clothes": 0.8, "ceiling": 1.4, "books": 0.5, "refridgerator": 0.5,
    "television": 0.6, "paper": 0.4, "towel": 0.3, "shower_curtain": 0.4, "box": 0.4,
    "whiteboard": 0.3, "person": 0.3, "night_stand": 0.3, "toilet": 0.3, "sink": 0.2, "lamp": 0.3,
    "bathtub": 0.2, "bag": 0.2, "otherstructure": 2.3, "otherfurniture": 1.9, "otherprop": 4.6,
}  # fmt: skip

# Objects in a picture: 146,617 labelled polygons in 10,335 pictures (Song, Lichtenberg, Xiao, SUN
# RGB-D, CVPR 2015); 35,064 objects in 1,449 pictures (Silberman et al., ECCV 2012).
OBJECTS_A_PICTURE: Final = {"SUN RGB-D": 14.2, "NYU Depth V2": 24.2}

# Mean and range of the slope of amplitude over frequency of 135 photographs (Tolhurst, Tadmor and
# Chao, Amplitude spectra of natural images, 1992); power falls twice as fast.
AMPLITUDE_SLOPE: Final = (-1.2, -1.5, -0.8)

# Kurtosis of the derivative of log luminance, 4,167 photographs, most of them outdoors (Huang and
# Mumford, Statistics of natural images and models, CVPR 1999).
GRADIENT_KURTOSIS: Final = 17.4
