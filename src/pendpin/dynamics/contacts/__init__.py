"""Dry friction and stops: which joints stick, slide or rest on a stop, what holds them, and when that changes.

contacts: the states and the forces; guards: what crosses 0 where they change; falls: bounces; binding: from the effects.
May import: what dynamics may.
"""
