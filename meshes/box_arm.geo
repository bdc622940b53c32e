// Thin-walled box arm, open at both ends. Made for kinetostat, to validate error bars.
// Regenerate box_arm.stl: scripts/make-meshes. Units mm. The arm runs along x from 0.
SetFactory("OpenCASCADE");

length = 200; width = 60; height = 40;  // along x, y, z
wall = 4;

Box(1) = {0, -width / 2, -height / 2, length, width, height};
Box(2) = {-1, wall - width / 2, wall - height / 2, length + 2, width - 2 * wall, height - 2 * wall};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };

Mesh.MeshSizeMin = 20;
Mesh.MeshSizeMax = 60;
