"""The equation doctor: printed equations checked against the true mechanics of a system, and mended.

reading/ turns text into trees; systems/ says what each quantity truly is. recognition finds the system that a text is about,
conventions its convention, letters the meaning of each letter, and printed makes equations of its statements. checking/
compares, definitions too; mending/ finds the smallest change that heals; verdicts weighs all equations of a text against
each other, accusations says what bears out that one is wrong; report holds what is found and shows it. diagnose is the
way in, diagnosis the main line.
May import: motions, dynamics, equations and what is below them; no other tool.
"""
