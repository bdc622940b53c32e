// Parallelogram bar of the Orthoglide: one of the two bars that form a leg.
// Made for kinetostat. Published: 310 mm between joints; 144 mm^2 is the effective section of the
// published tables. The section is a regular octagon: its second moment of area is within 0.3 % of
// the round rod's (1650 mm^4), and flat faces need no fine facets.
// Regenerate bar.stl: scripts/make-meshes
// Units mm. Origin: centre of the first bore; x along the bar; bore axes along y.
SetFactory("OpenCASCADE");

length = 310;          // between bore centres
section_area = 144;
boss_diameter = 24;
boss_width = 18;       // along y
bore_diameter = 10;

// Octagon in the y-z plane with two faces normal to y.
side = Sqrt(section_area / (2 * (1 + Sqrt(2))));
half = side * (1 + Sqrt(2)) / 2;  // half the width across flats
Point(1) = {0, half, -side / 2};  Point(2) = {0, half, side / 2};
Point(3) = {0, side / 2, half};   Point(4) = {0, -side / 2, half};
Point(5) = {0, -half, side / 2};  Point(6) = {0, -half, -side / 2};
Point(7) = {0, -side / 2, -half}; Point(8) = {0, side / 2, -half};
For i In {1 : 8}
  Line(i) = {i, i % 8 + 1};
EndFor
Curve Loop(1) = {1 : 8};
Plane Surface(1) = {1};
Extrude {length, 0, 0} { Surface{1}; }

Cylinder(2) = {0, -boss_width / 2, 0, 0, boss_width, 0, boss_diameter / 2};
Cylinder(3) = {length, -boss_width / 2, 0, 0, boss_width, 0, boss_diameter / 2};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };

Cylinder(5) = {0, -boss_width, 0, 0, 2 * boss_width, 0, bore_diameter / 2};
Cylinder(6) = {length, -boss_width, 0, 0, 2 * boss_width, 0, bore_diameter / 2};
BooleanDifference(7) = { Volume{4}; Delete; }{ Volume{5, 6}; Delete; };

// Facets: 48 segments round each rim of the bores, coarser elsewhere.
box = 0.6 * bore_diameter;
For i In {0 : 1}
  For side_of_y In {-1 : 1 : 2}
    y = side_of_y * boss_width / 2;
    rim() = Curve In BoundingBox{i * length - box, y - 0.1, -box, i * length + box, y + 0.1, box};
    Transfinite Curve{rim()} = 48 + 1;
  EndFor
EndFor
Mesh.MeshSizeFromCurvature = 24;
Mesh.MeshSizeMax = 8;
