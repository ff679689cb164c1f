// Building A of two_frames.toml: six floors of 18 m x 12 m, columns on a grid of 6 m x 5.25 m, a wall with doors along x.
// The mesh:  gmsh two_frames.geo -2 -format msh41 -o two_frames.msh
// Names of the groups: docs/mesh-groups.md. Metres, z upwards.
SetFactory("OpenCASCADE");

DefineConstant[ size = 1.0 ];         // of the elements: six in a bay of 6 m; gmsh -setnumber size 2 ... makes others
length = 18;                          // along x
width = 12;                           // along y; building B stands beyond y = 12 m
z[] = {0, 4.2, 7.6, 11.0, 14.4, 17.8, 21.2};
xs[] = {0, 6, 12, 18};                // lines of columns
// The last line stands back from the slab's edge by 1.5 m: A meets B with its slabs alone.
ys[] = {0, 5.25, 10.5};
door_left = 8.4; door_right = 9.6; door_height = 2.2;
floors = #z[] - 1;

// Everything is drawn on its own; BooleanFragments then lets what meets share its nodes.
For k In {1 : floors}
  slab = news; Rectangle(slab) = {0, 0, z[k], length, width};

  // The wall of a storey: a polygon around its door.
  base = z[k - 1];
  corner[] = {};
  corner[] += newp; Point(newp) = {xs[1], ys[1], base};
  corner[] += newp; Point(newp) = {door_left, ys[1], base};
  corner[] += newp; Point(newp) = {door_left, ys[1], base + door_height};
  corner[] += newp; Point(newp) = {door_right, ys[1], base + door_height};
  corner[] += newp; Point(newp) = {door_right, ys[1], base};
  corner[] += newp; Point(newp) = {xs[2], ys[1], base};
  corner[] += newp; Point(newp) = {xs[2], ys[1], z[k]};
  corner[] += newp; Point(newp) = {xs[1], ys[1], z[k]};
  side[] = {};
  For i In {0 : 7}
    side[] += newl; Line(newl) = {corner[i], corner[(i + 1) % 8]};
  EndFor
  loop = newcl; Curve Loop(loop) = {side[]};
  wall = news; Plane Surface(wall) = {loop};

  For i In {0 : 3}
    For j In {0 : 2}
      p = newp; Point(p) = {xs[i], ys[j], z[k - 1]};
      q = newp; Point(q) = {xs[i], ys[j], z[k]};
      l = newl; Line(l) = {p, q};
    EndFor
    // Across: to the edge that faces B.
    p = newp; Point(p) = {xs[i], 0, z[k]};
    q = newp; Point(q) = {xs[i], width, z[k]};
    l = newl; Line(l) = {p, q};
  EndFor
  For j In {0 : 2}
    For i In {0 : 2}
      p = newp; Point(p) = {xs[i], ys[j], z[k]};
      q = newp; Point(q) = {xs[i + 1], ys[j], z[k]};
      // Above the wall there is no beam.
      If (i != 1 || j != 1)
        l = newl; Line(l) = {p, q};
      EndIf
    EndFor
  EndFor

  // The mass centre: the middle of the plan.
  p = newp; Point(p) = {length / 2, width / 2, z[k]};
EndFor
BooleanFragments{ Surface{:}; Curve{:}; Point{:}; Delete; }{ }

// Groups, by where they are.
e = 1e-4;
For k In {1 : floors}
  Physical Surface(Sprintf("floor_%g", k)) = Surface In BoundingBox {-e, -e, z[k] - e, length + e, width + e, z[k] + e};
  Physical Surface(Sprintf("storey_%g", k)) = Surface In BoundingBox {xs[1] - e, ys[1] - e, z[k - 1] - e, xs[2] + e, ys[1] + e, z[k] + e};
  Physical Curve(Sprintf("edge_%g", k)) = Curve In BoundingBox {-e, width - e, z[k] - e, length + e, width + e, z[k] + e};
  Physical Point(Sprintf("centre_%g", k)) = Point In BoundingBox {length / 2 - e, width / 2 - e, z[k] - e, length / 2 + e, width / 2 + e, z[k] + e};
  across[] = {};
  along[] = {};
  columns[] = {};
  For i In {0 : 3}
    across[] += Curve In BoundingBox {xs[i] - e, -e, z[k] - e, xs[i] + e, width + e, z[k] + e};
    For j In {0 : 2}
      columns[] += Curve In BoundingBox {xs[i] - e, ys[j] - e, z[k - 1] - e, xs[i] + e, ys[j] + e, z[k] + e};
    EndFor
  EndFor
  For j In {0 : 2}
    For i In {0 : 2}
      If (i != 1 || j != 1)
        along[] += Curve In BoundingBox {xs[i] - e, ys[j] - e, z[k] - e, xs[i + 1] + e, ys[j] + e, z[k] + e};
      EndIf
    EndFor
  EndFor
  Physical Curve(Sprintf("beam_%g_across", k)) = {across[]};
  Physical Curve(Sprintf("beam_%g_along", k)) = {along[]};
  Physical Curve(Sprintf("column_%g", k)) = {columns[]};
EndFor
Physical Point("base") = Point In BoundingBox {-e, -e, -e, length + e, width + e, e};
Physical Curve("base") = Curve In BoundingBox {-e, -e, -e, length + e, width + e, e};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Mesh.Algorithm = 6;
Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 1;
