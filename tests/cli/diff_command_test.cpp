#include "run_recede.h"
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace recede::test {
namespace {

using testing::HasSubstr;

Rgb encoded_grey(double value) { return Rgb::Constant(decode_srgb(static_cast<float>(value))); }

/// Two pictures of 40 x 30 pixels that differ in the square from (10, 10) to (20, 20), and a mask of its left
/// half.
struct Pictures {
  TempFolder folder;
  Image a{40, 30, encoded_grey(0.4)}, b = a, mask{40, 30};
  std::string a_file = folder / "a.png", b_file = folder / "b.png", mask_file = folder / "mask.png";

  Pictures() {
    for (int y = 10; y < 20; ++y) {
      for (int x = 10; x < 20; ++x) {
        b.at(x, y) = encoded_grey(0.6);
        if (x < 15) mask.at(x, y) = Rgb::Ones();
      }
    }
    write_image(a_file, a);
    write_image(b_file, b);
    write_image(mask_file, mask);
  }
};

// Numbers are printed with all their digits, so they are the library's up to the last.
constexpr double k_rounding = 1e-12;

TEST(Diff, GivesTheMeasuresOfTheLibrary) {
  const Pictures p;
  const nlohmann::json json = json_of(run_recede({"diff", p.a_file, p.b_file, "--json"}));
  EXPECT_EQ(json["width"], 40);
  EXPECT_EQ(json["height"], 30);
  EXPECT_EQ(json["pixels"], 1200);
  EXPECT_NEAR(json["rmse"], 0.2 * std::sqrt(100 / 1200.0), 1e-6);  // of floats; 0.4 and 0.6 are whole 255ths
  EXPECT_NEAR(json["psnr"], -20 * std::log10(json["rmse"].get<double>()), k_rounding);
  EXPECT_NEAR(json["max"], 0.2, 1e-6);
  EXPECT_NEAR(json["changed_share"], 1 / 12.0, k_rounding);
  const Image a = read_image(p.a_file), b = read_image(p.b_file);
  EXPECT_NEAR(json["ssim"], compute_ssim(a, b).mean, k_rounding);
  EXPECT_NEAR(json["flip"], compute_flip(a, b).mean, k_rounding);
  EXPECT_EQ(json["pixels_per_degree"], 67.02);
  EXPECT_TRUE(json["mask"].is_null());
  const nlohmann::json near =
      json_of(run_recede({"diff", p.a_file, p.b_file, "--pixels-per-degree", "20", "--json"}));
  EXPECT_NEAR(near["flip"], compute_flip(a, b, {.pixels_per_degree = 20}).mean, k_rounding);
}

TEST(Diff, OfEqualPicturesFindsNothing) {
  const Pictures p;
  const nlohmann::json json =
      json_of(run_recede({"diff", p.a_file, p.a_file, "--json", "--fail-above", "0"}));
  EXPECT_EQ(json["flip"], 0);
  EXPECT_EQ(json["ssim"], 1);
  EXPECT_TRUE(json["psnr"].is_null());
  EXPECT_THAT(run_recede({"diff", p.a_file, p.a_file}).output, HasSubstr("psnr         inf dB"));
}

TEST(Diff, PrintsText) {
  const Pictures p;
  const CommandResult run = run_recede({"diff", p.a_file, p.b_file});
  EXPECT_EQ(run.code, 0) << "a difference is no failure";
  EXPECT_EQ(run.remarks, "");
  for (const char* part : {"40 x 30 pixels, 1200 compared", "flip ", "ssim ", "psnr         24.77 dB",
                           "rmse         0.05774", "maximum      0.20000", "changed      8.333 %"})
    EXPECT_THAT(run.output, HasSubstr(part));
}

TEST(Diff, CountsOnlyWhatIsInsideTheMask) {
  const Pictures p;
  const nlohmann::json json =
      json_of(run_recede({"diff", p.a_file, p.b_file, "--mask", p.mask_file, "--json"}));
  EXPECT_EQ(json["pixels"], 50);
  EXPECT_NEAR(json["rmse"], 0.2, 1e-6);
  EXPECT_EQ(json["changed_share"], 1);
  EXPECT_EQ(json["mask"], p.mask_file);
  EXPECT_NEAR(json["flip"],
              compute_flip(read_image(p.a_file), read_image(p.b_file), {}, mask_of(p.mask)).mean, k_rounding);
}

TEST(Diff, WritesMapsAsColoursOrAsValues) {
  const Pictures p;
  const Image a = read_image(p.a_file), b = read_image(p.b_file);
  FloatRaster dissimilarity = compute_ssim(a, b).map;
  for (float& value : dissimilarity.samples) value = 1 - value;
  const std::vector<std::pair<std::string, FloatRaster>> maps{
      {"flip", compute_flip(a, b).map},
      {"ssim", dissimilarity},
      {"difference", compare_images(a, b).magnitudes}};
  const std::string png = p.folder / "map.png", exr = p.folder / "map.exr";
  for (const auto& [name, map] : maps) {
    EXPECT_EQ(run_recede({"diff", p.a_file, p.b_file, "-o", exr, "--map", name}).code, 0);
    EXPECT_EQ(read_exr(exr), map) << name;
    EXPECT_EQ(run_recede({"diff", p.a_file, p.b_file, "-o", png, "--map", name}).code, 0);
    EXPECT_EQ(read_whole_file(png), encode_png(heat_map(map, 1))) << name;
  }
  EXPECT_EQ(json_of(run_recede({"diff", p.a_file, p.b_file, "-o", png, "--json"}))["output"], png);
  EXPECT_EQ(read_whole_file(png), encode_png(heat_map(maps[0].second, 1))) << "FLIP without --map";
}

TEST(Diff, FailsAboveALimitAfterTheResult) {
  const Pictures p;
  const std::string map = p.folder / "map.png";
  const CommandResult run =
      run_recede({"diff", p.a_file, p.b_file, "--json", "--fail-above", "0.001", "-o", map});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.remarks, testing::MatchesRegex("recede: FLIP of 0\\.[0-9]+ is above 0\\.001\n"));
  EXPECT_GT(nlohmann::json::parse(run.output)["flip"], 0.001);
  EXPECT_TRUE(std::filesystem::exists(map));
  EXPECT_EQ(run_recede({"diff", p.a_file, p.b_file, "--fail-above", "0.5"}).code, 0);
}

TEST(Diff, ReadsOpenExr) {
  const Pictures p;
  const std::string exr = p.folder / "a.exr";
  write_image(exr, p.a);
  // Encoding and decoding 8 bits gives back the same floats to their rounding.
  EXPECT_NEAR(json_of(run_recede({"diff", exr, p.a_file, "--json"}))["max"], 0, 1e-6);
}

TEST(Diff, WhatCannotBeComparedGetsOneLine) {
  const Pictures p;
  const std::string small = p.folder / "small.png", text = p.folder.write("text.png", "hello");
  write_image(small, Image(4, 3));
  const std::string sizes = ": has 4 x 3 pixels, but " + p.a_file + " has 40 x 30";
  EXPECT_EQ(complaint_of(run_recede({"diff", p.a_file, small}), 1), "recede: " + small + sizes);
  EXPECT_EQ(complaint_of(run_recede({"diff", p.a_file, p.b_file, "--mask", small}), 1),
            "recede: " + small + sizes);
  EXPECT_EQ(complaint_of(run_recede({"diff", text, p.a_file}), 1),
            "recede: " + text + ": is neither a PNG nor an OpenEXR picture");
  EXPECT_EQ(complaint_of(run_recede({"diff", p.a_file, "missing.png"}), 1),
            "recede: missing.png: No such file or directory");
  write_image(p.mask_file, Image(40, 30));
  EXPECT_EQ(complaint_of(run_recede({"diff", p.a_file, p.b_file, "--mask", p.mask_file}), 1),
            "recede: " + p.mask_file + ": no pixel is lighter than 0.5");
  const std::string jpg = p.folder / "map.jpg";
  EXPECT_EQ(complaint_of(run_recede({"diff", p.a_file, p.b_file, "-o", jpg}), 1),
            "recede: " + jpg + ": unknown kind of picture file; known are .png .exr");
}

TEST(Diff, HasTheSameMapForAnyNumberOfThreads) {
  const Pictures p;
  const std::string one = p.folder / "one.exr", two = p.folder / "two.exr";
  run_recede({"diff", p.a_file, p.b_file, "-o", one, "--threads", "1"});
  run_recede({"diff", p.a_file, p.b_file, "-o", two, "--threads", "2"});
  EXPECT_EQ(read_whole_file(one), read_whole_file(two));
}

/// The commands of the page, with files in the folder.
std::vector<std::vector<std::string>> commands_of_page(const TempFolder& folder) {
  std::istringstream page(read_whole_file(std::filesystem::path(RECEDE_SOURCE) / "docs/diff.md"));
  std::vector<std::vector<std::string>> commands;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("recede ")) continue;
    std::istringstream words(line.substr(7));
    commands.emplace_back();
    for (std::string word; words >> word;)
      commands.back().push_back(word.ends_with(".png") || word.ends_with(".ply") ? std::string(folder / word)
                                                                                 : word);
  }
  return commands;
}

TEST(DiffCommand, LooksWhereTheModelIsAsThePageSays) {
  const TempFolder folder;
  std::vector<std::vector<std::string>> commands = commands_of_page(folder);
  ASSERT_EQ(commands.size(), 4u);
  nlohmann::json json;
  for (std::vector<std::string>& command : commands) {
    command.push_back("--json");
    json = json_of(run_recede(command));
  }
  // The teapot covers some of the picture, and there alone it differs more than on the whole.
  const double seen = json["pixels"].get<double>() / (800 * 600);
  EXPECT_GT(seen, 0.1);
  EXPECT_LT(seen, 0.6);
  std::vector<std::string> whole = commands.back();
  whole.erase(std::find(whole.begin(), whole.end(), "--mask"), whole.end());
  whole.push_back("--json");
  const double of_all = json_of(run_recede(whole))["flip"];
  // Differences along the outline, just outside of the mask, count for the whole only.
  EXPECT_NEAR(json["flip"].get<double>() * seen, of_all, 0.2 * of_all);
}

TEST(DiffCommand, MasksHaveTheShareOfThePixelThatIsSeen) {
  const TempFolder folder;
  folder.write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const std::string mask_file = folder / "mask.exr";
  // One unit away a field of view of 90 degrees is two units wide: 8 pixels are one unit.
  const std::vector<std::string> view{"render",
                                      folder / "square.obj",
                                      "--eye",
                                      "0",
                                      "0.5",
                                      "1",
                                      "--look-at",
                                      "0",
                                      "0.5",
                                      "0",
                                      "-o",
                                      folder / "a.png",
                                      "--image-width",
                                      "16",
                                      "--image-height",
                                      "16",
                                      "--field-of-view",
                                      "90",
                                      "--mask",
                                      mask_file};
  std::vector<std::string> with_ground = view;
  with_ground.insert(with_ground.end(), {"--ground", "--lighting", "direct", "--wireframe", "--json"});
  EXPECT_EQ(json_of(run_recede(with_ground))["mask"], mask_file);
  const Image mask = read_image(mask_file);
  ASSERT_EQ(mask.width, 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const bool is_seen = x >= 8 && y >= 4 && y < 12;
      EXPECT_EQ(mask.pixels[static_cast<std::size_t>(16 * y + x)], Rgb(Rgb::Constant(is_seen ? 1.0f : 0.0f)))
          << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace recede::test
