"""The bundled example: a description and its sky."""
