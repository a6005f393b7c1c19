// Commands that are killed at any moment leave whole files or none.
#include "run_recede.h"

#include <fmt/format.h>

#include <csignal>
#include <map>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

struct Killed {
  const char* name;
  std::vector<std::string> arguments;  ///< `IN`: a sphere's file; `OUT`: what is written, without extension
  friend std::ostream& operator<<(std::ostream& out, const Killed& killed) { return out << killed.name; }
};

class KilledCommand : public testing::TestWithParam<Killed> {};
INSTANTIATE_TEST_SUITE_P(
    Commands, KilledCommand,
    testing::Values(Killed{"Simplify", {"simplify", "IN", "-o", "OUT.glb", "--ratio", "0.5"}},
                    // Large enough to be caught while it is written.
                    Killed{"Subdivide", {"subdivide", "IN", "-o", "OUT.ply", "--subdivision-level", "4"}},
                    Killed{"Bake",
                           {"bake", "IN", "-o", "OUT", "--ratios", "0.5", "0.2", "--maps", "normal",
                            "--map-size", "1024", "--no-report", "--no-billboards"}},
                    Killed{"Progressive", {"progressive", "IN", "-o", "OUT.pmesh"}},
                    Killed{"Shell",
                           {"shell", "IN", "-o", "OUT.shell", "--relative-thickness", "0.05", "--texture",
                            "solid", "--texels", "64"}},
                    Killed{"Render", {"render", "IN", "-o", "OUT.png", "--image-width", "64"}}),
    [](const auto& tested) { return std::string(tested.param.name); });

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const std::string& name : names_below(folder)) {
    if (fs::is_regular_file(folder / name)) files[name] = read_whole_file(folder / name);
  }
  return files;
}

TEST_P(KilledCommand, LeavesWholeFilesOrNone) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 3000);
  const auto arguments = [&](const fs::path& out) {
    fs::create_directory(out);
    std::vector<std::string> words = GetParam().arguments;
    for (std::string& word : words) {
      if (word == "IN") word = sphere;
      if (word.starts_with("OUT")) word = (out / word).string();
    }
    return words;
  };
  const CommandResult whole_run = run_recede(arguments(folder / "whole"));
  ASSERT_EQ(whole_run.code, 0) << whole_run.remarks;
  const auto expected = files_of(folder / "whole");
  ASSERT_FALSE(expected.empty());
  // As soon as there is one name in the folder, two, ..., which is while something is written; and again
  // until a kill has struck, which comes too late where this process had to wait for a processor.
  std::size_t kills = 0;
  constexpr std::size_t k_most_tries = 50;
  for (std::size_t n = 1; n <= expected.size() + 1 || (kills == 0 && n < k_most_tries); ++n) {
    const fs::path out = folder / fmt::format("killed{}", n);
    const std::size_t wanted = n <= expected.size() + 1 ? n : 1;
    const CommandResult run =
        run_recede_and_kill(arguments(out), [&] { return n_names_below(out) >= wanted; });
    kills += run.code == 128 + SIGKILL ? 1 : 0;
    for (const auto& [name, content] : files_of(out)) {
      if (name.find(".part") != name.npos) continue;  // not under a name that anything reads
      const auto same = expected.find(name);
      ASSERT_NE(same, expected.end()) << name;
      EXPECT_TRUE(content == same->second)
          << name << " is " << content.size() << " bytes long, not " << same->second.size();
    }
  }
  EXPECT_GT(kills, 0u);
}

}  // namespace
}  // namespace recede::test
