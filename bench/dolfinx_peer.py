"""The 6x6 of the foot of bench/compare-fea by dolfinx 0.5: mesh.inp SOLVER result.json, SOLVER gamg or mumps.

The nodes of INTERFACE0 are held, those of INTERFACE1 follow six unit motions of the reference point in turn, and the
work of the reactions is the stiffness: one preparation of the solver, six solutions."""
import json
import re
import resource
import sys

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

YOUNG, POISSON = 70e9, 0.33
OPTIONS = {
    "gamg": {"ksp_type": "cg", "ksp_rtol": 1e-9, "ksp_norm_type": "natural", "pc_type": "gamg",
             "pc_gamg_threshold": 0.01, "mg_levels_ksp_type": "chebyshev", "mg_levels_pc_type": "jacobi",
             "mg_levels_ksp_max_it": 3},
    "mumps": {"ksp_type": "preonly", "pc_type": "cholesky", "pc_factor_mat_solver_type": "mumps"},
}


def read_deck(path):
    """Nodes [m] and elements, both from 0; the interfaces' nodes; the reference point."""
    text = open(path).read()

    nodes = np.array(re.sub(r"[,\n]", " ", text[text.index("\n", text.index("*NODE")) + 1:text.index("*NODE, NSET=REF1")]).split(),
                     dtype=float).reshape(-1, 4)[:, 1:]
    start = text.index("\n", text.index("*ELEMENT")) + 1
    cells = np.array(text[start:text.index("*MATERIAL")].replace(",", " ").split(), dtype=np.int64).reshape(-1, 11)[:, 1:] - 1
    interfaces = []
    for k in (0, 1):
        begin = text.index("\n", text.index(f"*NSET, NSET=INTERFACE{k}")) + 1
        interfaces.append(np.array(text[begin:text.index("*", begin)].replace(",", " ").split(), dtype=np.int64) - 1)
    reference = text[text.index("\n", text.index("*NODE, NSET=REF1")) + 1:]
    point = np.array([float(x) for x in reference[:reference.index("\n")].split(",")[1:]])
    return nodes, cells, interfaces, point


def make_mesh(nodes, cells):
    """The corners with straight edges; the mid nodes are those of the space. Process 0 hands them out."""
    corners, local = np.unique(cells[:, :4], return_inverse=True)
    if MPI.COMM_WORLD.rank == 0:
        x, connectivity = nodes[corners], local.reshape(-1, 4)
    else:
        x, connectivity = np.zeros((0, 3)), np.zeros((0, 4), dtype=np.int64)
    element = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 1))
    return dolfinx.mesh.create_mesh(MPI.COMM_WORLD, connectivity, x, element)


def rigid_motions(space, point):
    """The six unit motions of all nodes, as functions."""
    motions = []
    for k in range(6):
        def motion(x, k=k):
            arm = x - point[:, None]
            axis = np.eye(3)[k % 3]
            return np.tile(axis[:, None], x.shape[1]) if k < 3 else np.cross(axis, arm.T).T
        function = fem.Function(space)
        function.interpolate(motion)
        motions.append(function)
    return motions


def near_nullspace(motions):
    basis = [motion.vector.copy() for motion in motions]
    for k, vector in enumerate(basis):
        for other in basis[:k]:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
    return PETSc.NullSpace().create(vectors=basis)


def face_dofs(space, points):
    """Blocks of the space at the nodes of an interface, which lie in a plane across x or y."""
    axis = int(np.argmin(np.ptp(points, axis=0)))
    return fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[axis], points[0, axis], atol=1e-9))


def stiffness_by(solver, mesh, point, held, loaded):
    space = fem.VectorFunctionSpace(mesh, ("Lagrange", 2))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    mu, lam = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    stress = 2 * mu * ufl.sym(ufl.grad(u)) + lam * ufl.div(u) * ufl.Identity(3)
    form = fem.form(ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx)
    prescribed = fem.Function(space)
    conditions = [fem.dirichletbc(np.zeros(3), face_dofs(space, held), space),
                  fem.dirichletbc(prescribed, face_dofs(space, loaded))]
    matrix = fem.petsc.assemble_matrix(form, bcs=conditions)
    matrix.assemble()
    free = fem.petsc.assemble_matrix(form)
    free.assemble()
    motions = rigid_motions(space, point)
    matrix.setNearNullSpace(near_nullspace(motions))
    for key, value in OPTIONS[solver].items():
        PETSc.Options()[key] = value
    ksp = PETSc.KSP().create(MPI.COMM_WORLD)
    ksp.setOperators(matrix)
    ksp.setFromOptions()
    fields, iterations = [], 0
    for motion in motions:
        motion.x.scatter_forward()
        prescribed.x.array[:] = motion.x.array
        start = matrix.createVecRight()  # the prescribed motion of the face, zero elsewhere
        fem.petsc.set_bc(start, conditions)
        load = matrix.createVecLeft()
        free.mult(start, load)
        load.scale(-1)
        fem.petsc.set_bc(load, conditions)
        field = matrix.createVecRight()
        ksp.solve(load, field)
        iterations = max(iterations, ksp.getIterationNumber())
        fields.append(field)
    products = [free * field for field in fields]
    return np.array([[a.dot(b) for b in products] for a in fields]), iterations


def main():
    deck, solver, result = sys.argv[1:]
    nodes, cells, interfaces, point = read_deck(deck)
    mesh = make_mesh(nodes, cells)
    stiffness, iterations = stiffness_by(solver, mesh, point, nodes[interfaces[0]], nodes[interfaces[1]])
    memory = MPI.COMM_WORLD.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    if MPI.COMM_WORLD.rank == 0:
        with open(result, "w") as file:
            json.dump({"compliance": np.linalg.inv(stiffness).tolist(), "iterations": iterations, "memory": memory}, file)


main()
