"""The triangles of an OBJ (gzipped) as nine doubles each, halved at their longest edges to about 200,000: triangles.py FILE.obj.gz OUT."""
import gzip
import sys

import numpy as np

COUNT = 200_000


def read(path):
    points, triangles = [], []
    for line in gzip.open(path, "rt", errors="replace"):
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [points[k - 1 if k > 0 else k] for k in corners]
            triangles += [(corners[0], b, c) for b, c in zip(corners[1:], corners[2:])]
    return np.array(triangles)


def divided(t, limit):
    """Triangles whose edges are at most `limit` long, or too many."""
    done, open_ = [], t
    while len(open_) and sum(map(len, done)) + len(open_) <= 2 * COUNT:
        edges = np.linalg.norm(np.roll(open_, -1, 1) - open_, axis=2)
        long = edges.max(1) > limit
        done.append(open_[~long])
        k = edges[long].argmax(1)
        a, b, o = (np.take_along_axis(open_[long], ((k + i) % 3)[:, None, None], 1)[:, 0] for i in range(3))
        m = 0.5 * (a + b)
        open_ = np.concatenate([np.stack([o, a, m], 1), np.stack([o, m, b], 1)])
    return np.concatenate([*done, open_])


t = read(sys.argv[1])
area = 0.5 * np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)
t = t[area > 1e-12]
low, high = 0.0, np.linalg.norm(np.roll(t, -1, 1) - t, axis=2).max()
for _ in range(24):
    middle = 0.5 * (low + high)
    low, high = (middle, high) if len(divided(t, middle)) > COUNT else (low, middle)
divided(t, high).tofile(sys.argv[2])
