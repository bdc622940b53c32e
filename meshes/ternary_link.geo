// Link with three bores. Made for kinetostat, to validate error bars.
// Regenerate ternary_link.stl: scripts/make-meshes. Units mm. Bores along z, one at the origin.
SetFactory("OpenCASCADE");

base = 120;           // between the two lower bores, along x
apex_x = 45; apex_y = 80;
thickness = 14;       // along z
boss_diameter = 40; bore_diameter = 20;

x() = {0, base, apex_x};
y() = {0, 0, apex_y};
For i In {0 : 2}
  Point(i + 1) = {x(i), y(i), -thickness / 2};
EndFor
For i In {1 : 3}
  Line(i) = {i, i % 3 + 1};
EndFor
Curve Loop(1) = {1 : 3};
Plane Surface(1) = {1};
Extrude {0, 0, thickness} { Surface{1}; }
For i In {0 : 2}
  Cylinder(2 + i) = {x(i), y(i), -thickness / 2, 0, 0, thickness, boss_diameter / 2};
  Cylinder(5 + i) = {x(i), y(i), -thickness, 0, 0, 2 * thickness, bore_diameter / 2};
EndFor
BooleanUnion(10) = { Volume{1}; Delete; }{ Volume{2 : 4}; Delete; };
BooleanDifference(11) = { Volume{10}; Delete; }{ Volume{5 : 7}; Delete; };

Mesh.MeshSizeFromCurvature = 16;
Mesh.MeshSizeMax = 40;
