"""What a room is made of and lit by, from its photographs.

``transport`` samples how light travels between the surfaces of a scene. ``observations`` picks
pixels of photographs with what they see. ``model`` predicts them, and ``solving`` finds the base
colours, lights and cameras that predict them best. ``gloss`` tells roughness and metals.
``authoring`` writes opinions.
"""
