"""Functional groups of furniture: what is used together stands together.

`sitting`, `sleeping`, `working`, `storing`, `wet`, `kitchen`: each by what people do there.
"""
