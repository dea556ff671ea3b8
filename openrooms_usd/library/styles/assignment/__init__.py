"""Which material things are made of: rooms by their type, parts by their name, as people noted it.

Tables say it and draws choose from them; nothing here knows how a material looks.

`rooms`: surfaces by the type of room; `kinds`, `weights`: parts by what they are; `annotations`: as
people noted it.
"""
