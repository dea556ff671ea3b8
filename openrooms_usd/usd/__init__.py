"""Authoring and reading USD by concept; knows no stage of the pipeline and no renderer."""
