#include "systems.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/version.h>

namespace recede::bench {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// CGAL 5.5 stops at a number of edges only, which is no number of faces on open meshes.
struct FaceCountStop {
  std::size_t faces;
  template <class Cost, class Profile>
  bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
    return profile.surface_mesh().number_of_faces() <= faces;
  }
};

Mesh to_mesh(const PolygonSoup& soup, std::size_t& refused_faces) {
  Mesh mesh;
  const auto vertices = static_cast<Mesh::size_type>(soup.positions.size());
  const auto faces = static_cast<Mesh::size_type>(soup.n_faces());
  mesh.reserve(vertices, vertices + faces, faces);
  for (const Vec3& p : soup.positions) mesh.add_vertex(Kernel::Point_3(p.x(), p.y(), p.z()));
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    const auto corners = soup.face(face);
    const auto added = mesh.add_face(Mesh::Vertex_index(corners[0]), Mesh::Vertex_index(corners[1]),
                                     Mesh::Vertex_index(corners[2]));
    if (added == Mesh::null_face()) ++refused_faces;
  }
  return mesh;
}

PolygonSoup to_soup(const Mesh& mesh) {
  PolygonSoup soup;
  for (const Mesh::Vertex_index vertex : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(vertex);
    soup.positions.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<Index> corners;
  for (const Mesh::Face_index face : mesh.faces()) {
    corners.clear();
    for (const Mesh::Vertex_index vertex : CGAL::vertices_around_face(mesh.halfedge(face), mesh)) {
      corners.push_back(static_cast<Index>(vertex));
    }
    soup.add_face(corners);
  }
  return soup;
}

/// `collapse` is the call to measure.
template <class Collapse>
Outcome run(const PolygonSoup& soup, const SimplifyTarget& target, Collapse collapse) {
  Outcome outcome;
  const WorkTimer setup;
  Mesh mesh = to_mesh(soup, outcome.refused_faces);
  outcome.setup_seconds = setup.wall();
  const CallMeter meter;
  collapse(mesh, FaceCountStop{target.faces.value()});
  meter.stop(outcome);
  mesh.collect_garbage();
  outcome.result = to_soup(mesh);
  return outcome;
}

Outcome run_lindstrom_turk(const PolygonSoup& soup, const SimplifyTarget& target) {
  return run(soup, target, [](Mesh& mesh, const FaceCountStop& stop) {
    sms::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(sms::LindstromTurk_cost<Mesh>())
                           .get_placement(sms::LindstromTurk_placement<Mesh>()));
  });
}

Outcome run_garland_heckbert(const PolygonSoup& soup, const SimplifyTarget& target) {
  return run(soup, target, [](Mesh& mesh, const FaceCountStop& stop) {
    const sms::GarlandHeckbert_plane_policies<Mesh, Kernel> policies(mesh);
    sms::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(policies.get_cost())
                           .get_placement(policies.get_placement())
                           .filter(sms::Bounded_normal_change_filter<>()));
  });
}

}  // namespace

void add_cgal(std::vector<System>& systems) {
  const std::string cgal = "CGAL " CGAL_VERSION_STR;
  systems.push_back({.name = cgal + " Lindstrom-Turk", .label = "CGAL LT", .run = run_lindstrom_turk});
  systems.push_back(
      {.name = cgal + " Garland-Heckbert planes", .label = "CGAL GH", .run = run_garland_heckbert});
}

}  // namespace recede::bench
