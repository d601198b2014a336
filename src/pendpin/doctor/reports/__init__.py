"""A diagnosis shown: text, records for machines, an HTML page with MathML, and the motion that wrong equations give.

May import: everything in the doctor.
"""
