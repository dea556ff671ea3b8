"""Files: looked through before USD opens them, stacked, and what is wrong with them.

Modules: `preflight`, `crate_reader`, `diagnostics`, `layers`, `strayed`.
"""
