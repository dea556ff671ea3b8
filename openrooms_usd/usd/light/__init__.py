"""Lights: authored, found and read as plain data, with their profiles.

Modules: `emitters`, `inputs`, `lightreader`, `lightsearch`, `shaping`, `profiles`, `lights`.
"""
