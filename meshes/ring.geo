// Ring with two lugs. Made for kinetostat, to validate error bars.
// Regenerate ring.stl: scripts/make-meshes. Units mm. The ring is about the z axis, its lugs on the x axis.
SetFactory("OpenCASCADE");

outer_diameter = 110; inner_diameter = 82; width = 20;  // width along z
lug_width = 24; lug_reach = 65;  // along y; from the axis

Cylinder(1) = {0, 0, -width / 2, 0, 0, width, outer_diameter / 2};
Box(2) = {-lug_reach, -lug_width / 2, -width / 2, 2 * lug_reach, lug_width, width};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Cylinder(4) = {0, 0, -width, 0, 0, 2 * width, inner_diameter / 2};
BooleanDifference(5) = { Volume{3}; Delete; }{ Volume{4}; Delete; };

Mesh.MeshSizeFromCurvature = 28;
Mesh.MeshSizeMax = 30;
