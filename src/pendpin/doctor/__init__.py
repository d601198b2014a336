"""The equation doctor: printed equations checked against the true mechanics of a system, and mended.

reading/ turns text into trees; systems/ says what each quantity truly is; recognition finds which system, in which letters
and convention, a text is about; checking/ compares; mending/ finds the smallest change that heals; verdicts weighs all
equations of a text against each other; report shows what is found.
diagnose is the way in, diagnosis the main line, findings what comes out.
May import: motions, dynamics, equations and what is below them; no other tool.
"""
