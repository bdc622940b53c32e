// I-beam with lightening holes in its web. Made for kinetostat, to validate error bars.
// Regenerate i_beam.stl: scripts/make-meshes. Units mm. The beam runs along x from 0.
SetFactory("OpenCASCADE");

length = 240; width = 40; height = 60;  // along x, y, z
flange = 6; web = 5;
hole_diameter = 28;

Box(1) = {0, -width / 2, -height / 2, length, width, flange};
Box(2) = {0, -width / 2, height / 2 - flange, length, width, flange};
Box(3) = {0, -web / 2, -height / 2, length, web, height};
BooleanUnion(4) = { Volume{1}; Delete; }{ Volume{2, 3}; Delete; };
For i In {1 : 3}
  Cylinder(10 + i) = {i * length / 4, -width, 0, 0, 2 * width, 0, hole_diameter / 2};
EndFor
BooleanDifference(5) = { Volume{4}; Delete; }{ Volume{11 : 13}; Delete; };

Mesh.MeshSizeFromCurvature = 20;
Mesh.MeshSizeMax = 40;
