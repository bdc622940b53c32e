// L-shaped foot with a bored boss. Made for kinetostat, to validate error bars.
// Regenerate l_foot.stl: scripts/make-meshes. Units mm. The foot stands on z = 0; its bore is along x.
SetFactory("OpenCASCADE");

depth = 50;  // of the plates, along y
base_length = 80; base_thickness = 12;
wall_height = 80; wall_thickness = 12;
boss_diameter = 34; boss_length = 24; bore_diameter = 18;
bore_z = 60;

Box(1) = {0, -depth / 2, 0, base_length, depth, base_thickness};
Box(2) = {0, -depth / 2, 0, wall_thickness, depth, wall_height};
Cylinder(3) = {0, 0, bore_z, boss_length, 0, 0, boss_diameter / 2};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Cylinder(5) = {-1, 0, bore_z, boss_length + 2, 0, 0, bore_diameter / 2};
BooleanDifference(6) = { Volume{4}; Delete; }{ Volume{5}; Delete; };

Mesh.MeshSizeFromCurvature = 20;
Mesh.MeshSizeMax = 30;
