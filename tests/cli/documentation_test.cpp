// What the documentation says of the command and of the code is so.
#include "run_recede.h"

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

const fs::path k_source = RECEDE_SOURCE;

std::vector<fs::path> pages() {
  std::vector<fs::path> found{k_source / "README.md", k_source / "CONTRIBUTING.md",
                              k_source / "CHANGELOG.md"};
  for (const auto& entry : fs::directory_iterator(k_source / "docs")) {
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  }
  return found;
}

std::set<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), expression), end; match != end; ++match) {
    found.insert((*match)[1]);
  }
  return found;
}

/// Lines without the blanks in front of them: a page may show the middle of a function.
std::string without_indentation(const std::string& text) {
  std::istringstream lines(text);
  std::string result, line;
  while (std::getline(lines, line)) {
    const std::size_t first = line.find_first_not_of(' ');
    result += (first == line.npos ? "" : line.substr(first)) + "\n";
  }
  return result;
}

std::vector<std::string> cpp_blocks(const std::string& page) {
  const std::string begin = "```cpp\n", end = "```";
  std::vector<std::string> blocks;
  for (std::size_t at = page.find(begin); at != page.npos; at = page.find(begin, at)) {
    at += begin.size();
    blocks.push_back(page.substr(at, page.find(end, at) - at));
  }
  return blocks;
}

TEST(Documentation, ShowsOnlyCodeOfTheExamplesThatTheTestsBuild) {
  std::string examples;
  for (const auto& entry : fs::directory_iterator(k_source / "examples")) {
    if (entry.path().extension() == ".cpp") examples += without_indentation(read_whole_file(entry.path()));
  }
  std::size_t n_blocks = 0;
  for (const fs::path& page : pages()) {
    for (const std::string& block : cpp_blocks(read_whole_file(page))) {
      ++n_blocks;
      EXPECT_TRUE(examples.find(without_indentation(block)) != examples.npos) << page << " shows\n" << block;
    }
  }
  EXPECT_GT(n_blocks, 0u);
}

TEST(Documentation, LinksOnlyToWhatIsThere) {
  for (const fs::path& page : pages()) {
    for (const std::string& link : matches(read_whole_file(page), R"(\]\(([^)#]+)[^)]*\))")) {
      if (link.starts_with("https://")) continue;
      EXPECT_TRUE(fs::exists(page.parent_path() / link)) << page << " links to " << link;
    }
  }
}

TEST(Documentation, HoldsOnlySmallPictures) {
  for (const auto& entry : fs::directory_iterator(k_source / "docs/images")) {
    EXPECT_LT(entry.file_size(), 150'000u) << entry.path();
  }
}

TEST(Documentation, NamesExactlyTheOptionsThatTheCommandHas) {
  constexpr const char* k_option = "(--[a-z][-a-z]+)";
  std::set<std::string> options{"--version"};
  for (const char* command : k_commands) {
    options.merge(matches(run_recede({command, "--help"}).output, k_option));
  }
  EXPECT_EQ(matches(read_whole_file(k_source / "docs/command-line.md"), k_option), options);
}

TEST(Documentation, ExplainsEveryFieldOfTheJsonThatTheCommandPrints) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "out";
  const std::string picture = (k_source / "docs/images/diff.png").string();
  std::set<std::string> fields;
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"info", sphere, "--json"},
           {"compare", sphere, sphere, "--json"},
           {"diff", picture, picture, "--json"},
           {"simplify", sphere, "-o", out + ".ply", "--ratio", "0.5", "--json"},
           {"bake", sphere, "-o", out, "--ratios", "0.5", "--maps", "displacement", "--map-size", "64",
            "--appearance", "--no-report", "--json"},
           {"render", (fs::path(out) / "sphere.recede").string(), "-o", out + ".png", "--level", "1",
            "--appearance", "auto", "--image-width", "8", "--json"},
           {"atlas", sphere, "-o", out + ".obj", "--json"},
           {"billboards", sphere, "--folder", out + "_clouds", "--relative-errors", "0.05", "--json"},
           {"shell", sphere, "-o", out + ".obj", "--relative-thickness", "0.05", "--side", "envelope",
            "--json"},
           {"shell", sphere, "-o", out + ".shell", "--relative-thickness", "0.05", "--texture", "solid",
            "--texels", "64", "--json"},
           {"carve", out + ".shell", "-o", out + "_ball.shell", "--ball", "0", "0", "1", "0.3", "--json"},
           {"carve", out + ".shell", "-o", out + "_copy.shell", "--move", "0", "0", "1", "--to", "0", "1",
            "0", "--radius", "0.3", "--copy", "--json"},
           {"subdivide", sphere, "-o", out + ".obj", "--subdivision-level", "0", "--json"},
           {"progressive", sphere, "-o", out + ".pmesh", "--json"},
           {"extract", out + ".pmesh", "-o", out + ".ply", "--json"},
           {"extract", out + ".pmesh", "-o", out + "_morph.ply", "--morph-ratio", "0.1", "--json"},
           {"extract", out + ".pmesh", "-o", out + "_view.ply", "--eye", "0", "0", "3", "--json"},
           {"render", out + ".ply", "-o", out + ".png", "--image-width", "8", "--json"},
           {"dice", (fs::path(out) / "sphere.recede").string(), "-o", out + "_diced.ply", "--image-width",
            "50", "--image-height", "50", "--json"},
           {"turntable", out + ".ply", "-o", out + "_frames", "--image-width", "8", "--frames", "2",
            "--json"}}) {
    collect_fields(json_of(run_recede(arguments)), fields);
  }
  const std::string list = folder.write("list.txt", sphere + "\n");
  collect_fields(json_of(run_recede({"batch", list, "-o", out + "_batch", "--json", "--", "--no-report"})),
                 fields);
  expect_explained(fields);
}

}  // namespace
}  // namespace recede::test
