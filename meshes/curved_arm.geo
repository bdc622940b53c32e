// Quarter of a circle with a rectangular section. Made for kinetostat, to validate error bars.
// Regenerate curved_arm.stl: scripts/make-meshes. Units mm. The circle is in the plane z = 0 about the
// origin, from the x axis to the y axis.
SetFactory("OpenCASCADE");

radius = 100;  // of the middle line
width = 24;    // along the radius
height = 16;   // along z

Rectangle(1) = {radius - width / 2, -height / 2, 0, width, height};
Rotate {{1, 0, 0}, {0, 0, 0}, Pi / 2} { Surface{1}; }
Extrude {{0, 0, 1}, {0, 0, 0}, Pi / 2} { Surface{1}; }

Mesh.MeshSizeFromCurvature = 64;
Mesh.MeshSizeMax = 16;
