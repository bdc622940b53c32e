// Tube with a flange at each end. Made for kinetostat, to validate error bars.
// Regenerate flanged_tube.stl: scripts/make-meshes. Units mm. The tube runs along x from 0.
SetFactory("OpenCASCADE");

length = 160;
outer_diameter = 44; inner_diameter = 32;
flange_diameter = 70; flange_thickness = 8;

Cylinder(1) = {0, 0, 0, length, 0, 0, outer_diameter / 2};
Cylinder(2) = {0, 0, 0, flange_thickness, 0, 0, flange_diameter / 2};
Cylinder(3) = {length - flange_thickness, 0, 0, flange_thickness, 0, 0, flange_diameter / 2};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
Cylinder(5) = {-1, 0, 0, length + 2, 0, 0, inner_diameter / 2};
BooleanDifference(6) = { Volume{4}; Delete; }{ Volume{5}; Delete; };

Mesh.MeshSizeFromCurvature = 14;
Mesh.MeshSizeMax = 30;
