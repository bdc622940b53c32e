// Two discs on a rod. Made for kinetostat, to validate error bars.
// Regenerate dumbbell.stl: scripts/make-meshes. Units mm. The rod runs along x from 0.
SetFactory("OpenCASCADE");

disc_diameter = 56; disc_thickness = 20;
rod_diameter = 22; length = 140;  // over all

Cylinder(1) = {0, 0, 0, length, 0, 0, rod_diameter / 2};
Cylinder(2) = {0, 0, 0, disc_thickness, 0, 0, disc_diameter / 2};
Cylinder(3) = {length - disc_thickness, 0, 0, disc_thickness, 0, 0, disc_diameter / 2};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };

Mesh.MeshSizeFromCurvature = 14;
Mesh.MeshSizeMax = 30;
