"""Which material things are made of: rooms by their type, parts by their name, as people noted it.

Tables say it and draws choose from them; nothing here knows how a material looks.
"""
