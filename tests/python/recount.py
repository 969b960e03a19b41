# SPDX-License-Identifier: GPL-3.0-or-later
"""Independent counts in numpy and plain Python, straight from the definitions (docs/measures.md).

Shares no code with the package and takes no short cuts: it is what the package is judged by.
"""

from collections import Counter, defaultdict
from itertools import pairwise

import numpy as np


def edge_faces(faces):
    """Faces of each undirected edge."""
    table = defaultdict(list)
    for face, (a, b, c) in enumerate(faces.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            table[tuple(sorted(edge))].append(face)
    return table


def piece_count(members, links):
    """Number of pieces that the members fall into when the linked ones are joined."""
    root = {member: member for member in members}

    def find(member):
        while root[member] != member:
            root[member] = member = root[root[member]]
        return member

    for one, other in links:
        root[find(one)] = find(other)
    return len({find(member) for member in members})


def measures(faces, labels):
    """The keys of docs/measures.md for one surface and its labels."""
    submesh_count = int(labels.max()) + 1
    edges = edge_faces(faces)
    cut = [edge for edge, users in edges.items() if len({labels[face] for face in users}) > 1]
    counts = np.bincount(labels, minlength=submesh_count)
    parted = apart_at_pinches(faces)
    per_submesh = [submesh_topology(parted[labels == label]) for label in range(submesh_count)]
    return {
        "submesh_count": submesh_count,
        "triangle_count": len(faces),
        "min_submesh_triangles": int(counts.min()),
        "max_submesh_triangles": int(counts.max()),
        "boundary_edge_count": len(cut),
        "max_triangle_count_difference": int(counts.max() - counts.min()),
        "coefficient_of_variation": float(np.sqrt(((counts - counts.mean()) ** 2).mean()))
        / float(counts.mean()),
        "bowtie_count": sum(bowties for bowties, _, _ in per_submesh),
        "disconnected_submesh_count": sum(pieces > 1 for _, pieces, _ in per_submesh),
        "disk_count": sum(disk for _, _, disk in per_submesh),
        "boundary_edge_ratio": len(cut) / len(edges),
        "submesh_triangles": counts,
    }


def fans_by_vertex(faces):
    """For each vertex the edge-connected sets of faces around it: more than one at a pinch."""
    around, links = faces_and_joints(faces)
    fans = {}
    for vertex, members in around.items():
        left = set(members)
        fans[vertex] = []
        while left:
            fan, border = set(), [min(left)]
            while border:
                face = border.pop()
                fan.add(face)
                border += {a + b - face for a, b in links[vertex] if face in (a, b)} - fan
            fans[vertex].append(fan)
            left -= fan
    return fans


def apart_at_pinches(faces):
    """The faces with a vertex of its own for each fan of the mesh."""
    faces = np.array(faces)
    next_vertex = faces.max() + 1
    for vertex, fans in fans_by_vertex(faces).items():
        for fan in fans[1:]:
            users = faces[list(fan)]
            faces[list(fan)] = np.where(users == vertex, next_vertex, users)
            next_vertex += 1
    return faces


def faces_and_joints(faces):
    """By vertex: its faces, and the pairs of them that meet in an edge there."""
    around, links = defaultdict(list), defaultdict(list)
    for face, corners in enumerate(faces.tolist()):
        for vertex in set(corners):
            around[vertex].append(face)
    for edge, users in edge_faces(faces).items():
        for vertex in edge:
            links[vertex] += pairwise(users)
    return around, links


def submesh_topology(faces):
    """(bowties, pieces, is a disk) of a sub-mesh with these faces."""
    if len(faces) == 0:
        return 0, 0, False
    edges = edge_faces(faces)
    pieces = piece_count(range(len(faces)), linked_faces(edges.values()))
    around, links = faces_and_joints(faces)
    bowties = sum(piece_count(around[vertex], links[vertex]) - 1 for vertex in around)
    border = [edge for edge, users in edges.items() if len(users) == 1]
    border_vertices = {vertex for edge in border for vertex in edge}
    loops = piece_count(border_vertices, border)
    euler = len(np.unique(faces)) - len(edges) + len(faces)
    return bowties, pieces, pieces == 1 and euler == 1 and loops == 1 and bowties == 0


def linked_faces(users_of_edges):
    return [pair for users in users_of_edges for pair in pairwise(users)]


def surface_faults(vertices, faces):
    """What keeps a mesh from being one closed, oriented, two-manifold surface of genus 0."""
    faults = []
    directed = Counter(edge for a, b, c in faces.tolist() for edge in ((a, b), (b, c), (c, a)))
    if any(count > 1 for count in directed.values()):
        faults.append("an edge is used twice in one direction")
    if any((b, a) not in directed for a, b in directed):
        faults.append("an edge has a face on one side only")
    used = np.unique(faces)
    if len(used) != len(vertices):
        faults.append("a vertex belongs to no face")
    if len(used) - len(directed) // 2 + len(faces) != 2:
        faults.append("the Euler characteristic is not 2")
    bowties, pieces, _ = submesh_topology(faces)
    if pieces != 1:
        faults.append("more than one piece")
    if bowties:
        faults.append("a vertex is not manifold")
    if len(np.unique(vertices, axis=0)) != len(vertices):
        faults.append("two vertices lie at one place")
    if (area_vectors(vertices, faces) == 0).all(axis=1).any():
        faults.append("a face has no area")
    if volume(vertices, faces) <= 0:
        faults.append("the surface looks inward")
    return faults


def area_vectors(vertices, faces):
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def areas(vertices, faces):
    return 0.5 * np.linalg.norm(area_vectors(vertices, faces), axis=1)


def weight_imbalance(labels, weights):
    loads = np.bincount(labels, weights)
    return float(loads.max() / loads.mean())


def volume(vertices, faces):
    return float(np.linalg.det(vertices[faces]).sum() / 6)


def flipped_triangle_count(positions, faces):
    """Triangles on the sphere that are not counter-clockwise seen from outside."""
    return int((np.linalg.det(positions[faces]) <= 0).sum())
