"""Dry friction and stops: which joints stick, slide or rest on a stop, what holds them, and when that changes.

contacts: from the effects to the states and the forces. falls: bounces, and the guards that cross 0 where states change.
May import: what dynamics may.
"""
