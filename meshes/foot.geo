// Orthoglide foot: carries the parallelogram from the carriage of one linear actuator.
// Made for kinetostat after the published layout (arm at 45 degrees to the actuator, joint 110 mm
// along and 110 mm beside it; section close to the effective beam of 29.4 x 16.4 mm).
// Regenerate foot.stl: scripts/make-meshes
// Units mm. Origin: centre of the mounting face, which lies in x = 0; the actuator runs along x.
SetFactory("OpenCASCADE");

reach = 110;           // joint centre at (reach, reach, 0)
arm_width = 30;        // in the x-y plane
arm_thickness = 16;    // along z
pad_thickness = 12;    // along x
pad_y_min = -32; pad_y_max = 42;
pad_height = 32;       // along z
boss_diameter = 36;
boss_height = 24;      // along z
bore_diameter = 16;

// The arm, drawn along x, turned by 45 degrees about z, cut off at the carriage.
arm_length = reach * Sqrt(2);
Box(1) = {-arm_width, -arm_width / 2, -arm_thickness / 2,
          arm_length + arm_width, arm_width, arm_thickness};
Rotate {{0, 0, 1}, {0, 0, 0}, Pi / 4} { Volume{1}; }
Box(2) = {-200, -200, -200, 200, 400, 400};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };

Box(4) = {0, pad_y_min, -pad_height / 2, pad_thickness, pad_y_max - pad_y_min, pad_height};
Cylinder(5) = {reach, reach, -boss_height / 2, 0, 0, boss_height, boss_diameter / 2};
BooleanUnion(6) = { Volume{3}; Delete; }{ Volume{4, 5}; Delete; };

Cylinder(7) = {reach, reach, -boss_height, 0, 0, 2 * boss_height, bore_diameter / 2};
BooleanDifference(8) = { Volume{6}; Delete; }{ Volume{7}; Delete; };

// Facets: 48 segments round each rim of the bore, coarser elsewhere.
box = 0.6 * bore_diameter;
For side In {-1 : 1 : 2}
  z = side * boss_height / 2;
  rim() = Curve In BoundingBox{reach - box, reach - box, z - 0.1, reach + box, reach + box, z + 0.1};
  Transfinite Curve{rim()} = 48 + 1;
EndFor
Mesh.MeshSizeFromCurvature = 32;
Mesh.MeshSizeMax = 10;
