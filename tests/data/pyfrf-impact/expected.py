#!/usr/bin/env python3
"""Writes expected.txt: H1 and coherence over the good hits of impact2_response0.npy, by NumPy.

A hit begins with the first sample 3 N above the mean of the 40 samples at the segment's start. Its record
is 2048 samples, 40 of them before that one; the mean of the first 35 of these is taken off. The
force is kept within 51 samples (1 ms) of its peak; both signals are windowed by exp(-120 t).
"""
from pathlib import Path

import numpy as np

RATE, POINTS, PRE_TRIGGER, REST = 51_200.0, 2048, 40, 35
LEVEL, DECAY, HALF_WIDTH = 3.0, 120.0, 51
GOOD, LINES = (1, 3, 4), 256

here = Path(__file__).parent
segments = np.load(here / "impact2_response0.npy")
n = np.arange(POINTS)
window = np.exp(-DECAY * n / RATE)

triggers, forces, responses = [], [], []
for segment in segments:
    force = segment[:, 0]
    triggers.append(int(np.argmax(force >= force[:PRE_TRIGGER].mean() + LEVEL)))
for hit in GOOD:
    start = triggers[hit] - PRE_TRIGGER
    record = segments[hit, start : start + POINTS]
    force, response = (record - record[:REST].mean(axis=0)).T
    near = np.abs(n - np.argmax(force)) <= HALF_WIDTH
    forces.append(np.fft.rfft(force * near * window)[:LINES])
    responses.append(np.fft.rfft(response * window)[:LINES])

F, X = np.array(forces), np.array(responses)
g_ff, g_xx = (np.abs(F) ** 2).mean(axis=0), (np.abs(X) ** 2).mean(axis=0)
g_xf = (X * F.conj()).mean(axis=0)
h1, coherence = g_xf / g_ff, np.abs(g_xf) ** 2 / (g_ff * g_xx)

with open(here / "expected.txt", "w", encoding="ascii", newline="\n") as out:
    print(*triggers, file=out)
    for h, c in zip(h1, coherence):
        print(f"{h.real:.12e} {h.imag:.12e} {c:.12e}", file=out)
