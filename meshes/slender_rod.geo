// Round rod, forty times as long as thick. Made for kinetostat, to validate error bars.
// Regenerate slender_rod.stl: scripts/make-meshes. Units mm. The rod runs along x from 0.
SetFactory("OpenCASCADE");

length = 400; diameter = 10;

Disk(1) = {0, 0, 0, diameter / 2};
Rotate {{0, 1, 0}, {0, 0, 0}, -Pi / 2} { Surface{1}; }
Transfinite Curve{1} = 16 + 1;
Extrude {length, 0, 0} { Surface{1}; Layers{20}; }

Mesh.MeshSizeMax = 10;
