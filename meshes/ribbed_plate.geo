// Plate with three ribs. Made for kinetostat, to validate error bars.
// Regenerate ribbed_plate.stl: scripts/make-meshes. Units mm. The plate lies on z = 0, its ribs run along x.
SetFactory("OpenCASCADE");

length = 160; width = 84; thickness = 5;  // along x, y, z
rib_thickness = 5; rib_height = 18;       // above the plate

Box(1) = {0, -width / 2, 0, length, width, thickness};
For i In {-1 : 1}
  Box(3 + i) = {0, i * (width - rib_thickness) / 2 - rib_thickness / 2, 0,
                length, rib_thickness, thickness + rib_height};
EndFor
BooleanUnion(5) = { Volume{1}; Delete; }{ Volume{2 : 4}; Delete; };

Mesh.MeshSizeMin = 20;
Mesh.MeshSizeMax = 60;
