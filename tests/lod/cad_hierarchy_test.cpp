// Assemblies: parts once, and where they are.
#include <recede/lod/cad_hierarchy.h>
// After OpenMesh's headers: OpenCASCADE has a macro Handle.
#include "cad_shapes.h"
#include "seam_models.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>

#include <gtest/gtest.h>

#include <numbers>

namespace recede {
namespace {

// Screws upright, laid down and enlarged, and mirrored, the last one red.
CadModel three_screws() {
  const test::TempFolder folder;
  test::write_brep(folder / "screw.brep", test::cad_screw());
  CadModel model = read_cad(folder / "screw.brep");
  model.materials = {{"red", {1, 0, 0, 1}, ""}};
  model.instances.assign(3, {.part = 0, .name = "upright"});
  model.instances[1].name = "laid down";
  model.instances[1].placement.translate(Vec3(40, 0, 0));
  model.instances[1].placement.rotate(Eigen::AngleAxisd(std::numbers::pi / 3, Vec3(1, 2, 3).normalized()));
  model.instances[1].placement.scale(1.5);
  model.instances[2].name = "mirrored";
  model.instances[2].placement.translate(Vec3(0, 40, 0));
  model.instances[2].placement.scale(Vec3(-1, 1, 1));
  model.instances[2].material = 0;
  return model;
}

CadHierarchy levels_of(const CadModel& model, const std::string& name, std::vector<double> errors) {
  CadHierarchyOptions options;
  options.errors = std::move(errors);
  return build_cad_hierarchy(model, name, options);
}

double volume_of(const PolygonSoup& soup) {
  double volume = 0;
  for (std::size_t f = 0; f < soup.n_faces(); ++f)
    volume += soup.positions[soup.face(f)[0]].dot(vector_area(soup, f)) / 3;
  return volume;
}

TEST(CadHierarchy, WritesInstancesThatAreReadAsTheSameTriangles) {
  const CadHierarchy built = levels_of(three_screws(), "screws", {0.05, 0.5});
  const test::TempFolder folder;
  const HierarchyFiles files = write_hierarchy(folder.path(), built.hierarchy);
  const PolygonSoup whole = to_soup(built.hierarchy.levels[0].mesh), read = read_soup(files.glb);
  ASSERT_EQ(read.n_faces(), whole.n_faces());
  // Floats of coordinates below 100, and of unit normals, put in their places by doubles.
  constexpr double k_rounding = 100 * 1.2e-7, k_normal_rounding = 4e-7;
  for (std::size_t c = 0; c < whole.n_corners(); ++c) {
    const Vec3 &a = whole.positions[whole.corner_vertices[c]], &b = read.positions[read.corner_vertices[c]];
    ASSERT_LT((a - b).norm(), k_rounding) << c;
    ASSERT_LT((whole.corner_normals[c] - read.corner_normals[c]).norm(), k_normal_rounding) << c;
  }
  const std::size_t of_one = whole.n_faces() / 3;
  for (std::size_t f = 0; f < whole.n_faces(); ++f)
    ASSERT_EQ(read.face_materials[f], f < 2 * of_one ? k_no_index : 0u) << f;
  // Outwards, the mirrored one as well: a part of the volume would be missing.
  const PolygonSoup& part = built.hierarchy.levels[0].parts[0];
  EXPECT_NEAR(volume_of(read), (2 + 1.5 * 1.5 * 1.5) * volume_of(part), 1e-5 * volume_of(part));
}

TEST(CadHierarchy, KeepsAPartOnceForEachLevelHoweverManyInstancesThereAre) {
  CadModel model = three_screws();
  const test::TempFolder folder;
  const auto bytes_of = [&](const std::string& name) {
    const CadHierarchy built = levels_of(model, name, {0.05, 0.5});
    EXPECT_EQ(built.hierarchy.levels[0].mesh.n_faces(),
              model.instances.size() * built.hierarchy.levels[0].parts[0].n_faces());
    return std::filesystem::file_size(write_hierarchy(folder.path(), built.hierarchy).glb);
  };
  const std::uintmax_t of_three = bytes_of("three");
  for (int i = 0; i < 97; ++i) {
    model.instances.push_back(model.instances[1]);
    model.instances.back().placement.pretranslate(Vec3(40.0 * (i + 1), 0, 0));
  }
  const std::uintmax_t of_hundred = bytes_of("hundred");
  // A node of each level: its name, the number of its mesh and a matrix of 16 numbers of up to 20 digits.
  EXPECT_LT(of_hundred - of_three, 97u * 2u * 420u);
}

CadModel model_of(std::vector<CadPart> parts, const std::vector<double>& scales) {
  CadModel model;
  model.parts = std::move(parts);
  for (Index part = 0; part < scales.size(); ++part) {
    CadInstance& instance = model.instances.emplace_back();
    instance.part = part;
    instance.placement.scale(scales[part]);
  }
  return model;
}

TEST(CadHierarchy, WeighsErrorsOfPartsByTheirAreasWhereTheyAre) {
  constexpr double k_error = 0.05;
  const std::vector<double> scales{1, 4};
  const CadModel model =
      model_of({test::part_of({test::whole(test::ball(1))}), test::part_of(test::can(1, 2))}, scales);
  double squares = 0, area = 0;
  for (std::size_t i = 0; i < scales.size(); ++i) {
    SeamModelOptions options;
    options.seams.tolerance = options.hierarchy.largest_error = k_error / scales[i];
    const SeamModel part = build_seam_model(model.parts[i], options);
    SeamTessellation tessellation(part);
    tessellation.update(k_error / scales[i]);
    const SampledDeviation sampled = tessellation.sampled_deviation();
    const double area_here = sampled.area * scales[i] * scales[i], rms_here = sampled.rms * scales[i];
    squares += rms_here * rms_here * area_here;
    area += area_here;
  }
  EXPECT_DOUBLE_EQ(levels_of(model, "round", {k_error}).hierarchy.levels[0].error.rms,
                   std::sqrt(squares / area));
}

TEST(CadHierarchy, RefusesViewsOutOfRange) {
  const CadModel model = model_of({test::part_of(test::box_faces({1, 1, 1}))}, {1});
  for (const ViewSettings& view : {ViewSettings{.pixel_error = 0}, ViewSettings{.image_height = NAN},
                                   ViewSettings{.field_of_view = -1}}) {
    CadHierarchyOptions options;
    options.view = view;
    EXPECT_THROW(build_cad_hierarchy(model, "box", options), OptionError);
  }
}

TEST(CadHierarchy, SaysWhichFacesHaveNoTrianglesAndWhy) {
  const NurbsSurface square = test::parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  TrimmedPatch crossed{square, {}, false, "bow"};
  const std::vector<Vec2> corners{{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  crossed.loops.emplace_back();
  for (std::size_t i = 0; i < 4; ++i)
    crossed.loops[0].curves.push_back(test::line(corners[i], corners[(i + 1) % 4]));
  CadPart part = test::part_of({crossed, test::whole(test::parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}))});
  part.name = "ribbon";
  const CadHierarchy built = levels_of(model_of({part}, {1}), "ribbon", {0.01});
  EXPECT_EQ(built.levels[0].missed,
            (std::vector<std::string>{
                "face bow of \"ribbon\": no triangles, as its loops cross or go around nothing"}));
}

TEST(CadHierarchy, PutsPartsWithoutInstancesWhereNodesOfGltfCant) {
  CadModel model = three_screws();
  model.instances[1].placement.linear()(0, 1) += 0.5;  // shear
  const CadHierarchy sheared = levels_of(model, "sheared", {0.05});
  EXPECT_TRUE(sheared.hierarchy.instances.empty());
  model.instances.resize(1);
  const CadHierarchy single = levels_of(model, "single", {0.05});
  EXPECT_TRUE(single.hierarchy.instances.empty());
  EXPECT_TRUE(single.hierarchy.levels[0].parts.empty());
  const test::TempFolder folder;
  EXPECT_EQ(read_soup(write_hierarchy(folder.path(), sheared.hierarchy).glb).n_faces(),
            sheared.hierarchy.levels[0].mesh.n_faces());
}

}  // namespace
}  // namespace recede
