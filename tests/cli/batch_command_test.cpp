// `recede batch`: many files, one after another or by parts, whatever ends in between.
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>

#include <map>

namespace recede::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> k_bake{"--", "--ratios", "0.5", "--no-report", "--no-billboards"};

class Batch : public testing::Test {
 protected:
  Batch() {
    for (const std::size_t faces : {100u, 200u, 300u, 400u, 500u}) {
      const fs::path file = folder_ / fmt::format("ball{}.ply", faces);
      write_soup(file, make_displaced_sphere(faces, true));
      text_ += file.string() + "\n";
    }
    list_ = folder_.write("list.txt", text_);
  }

  std::vector<std::string> arguments(std::vector<std::string> more = {}, const fs::path& out = "out") const {
    std::vector<std::string> all{"batch", list_.string(), "-o", (folder_ / out.string()).string(), "--json"};
    all.insert(all.end(), more.begin(), more.end());
    all.insert(all.end(), k_bake.begin(), k_bake.end());
    return all;
  }

  /// Counts of baked, done before and failed.
  static std::vector<int> counts(const CommandResult& run) {
    const nlohmann::json document = nlohmann::json::parse(run.output, nullptr, false);
    if (document.is_discarded()) return {};
    return {document["baked"], document["done_before"], document["failed"]};
  }

  TempFolder folder_;
  std::string text_;
  fs::path list_;
};

/// All files below a folder, without those that hold times.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const std::string& name : names_below(folder)) {
    const fs::path file = folder / name;
    if (fs::is_regular_file(file) && file.filename() != "batch.json") files[name] = read_whole_file(file);
  }
  return files;
}

TEST_F(Batch, BakesEachFileOnce) {
  list_ = folder_.write("list.txt", "# balls\n\n" + text_ + "teapot\tpots/tea\r\n");
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(6, 0, 0));
  EXPECT_TRUE(fs::exists(folder_ / "out/ball100/ball100.glb"));
  EXPECT_TRUE(fs::exists(folder_ / "out/pots/tea/teapot.glb"));
  const auto time = fs::last_write_time(folder_ / "out/ball100/ball100.glb");
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(0, 6, 0));
  EXPECT_EQ(fs::last_write_time(folder_ / "out/ball100/ball100.glb"), time);
  EXPECT_THAT(counts(run_recede(arguments({"--again"}))), ElementsAre(6, 0, 0));
}

TEST_F(Batch, TakesNamesThatAreNotUtf8) {
  const std::string file = (folder_ / "ball\xff.ply").string();
  write_soup(file, make_displaced_sphere(100, true));
  list_ = folder_.write("list.txt", file + "\n");
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(1, 0, 0));
  EXPECT_TRUE(fs::exists(folder_ / "out/ball\xff/ball\xff.glb"));
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(0, 1, 0));
}

TEST_F(Batch, WritesWhatBakeWrites) {
  EXPECT_THAT(counts(run_recede(arguments({"--jobs", "2"}))), ElementsAre(5, 0, 0));
  std::vector<std::string> alone{"bake", folder_ / "ball300.ply", "-o", folder_ / "alone"};
  alone.insert(alone.end(), k_bake.begin() + 1, k_bake.end());
  EXPECT_EQ(run_recede(alone).code, 0);
  EXPECT_EQ(contents(folder_ / "out/ball300"), contents(folder_ / "alone"));
  const nlohmann::json record = nlohmann::json::parse(read_whole_file(folder_ / "out/ball300/batch.json"));
  EXPECT_EQ(record["result"]["levels"].size(), 2u);
  EXPECT_GT(record["peak_bytes"].get<double>(), 1e6);
}

TEST_F(Batch, BakesAnewWhatWasMadeFromOtherFilesOrByOtherOptions) {
  run_recede(arguments());
  write_soup(folder_ / "ball200.ply", make_displaced_sphere(250, true));
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(1, 4, 0));
  std::vector<std::string> others = arguments();
  others.insert(others.end(), {"--feature-angle", "40"});
  EXPECT_THAT(counts(run_recede(others)), ElementsAre(5, 0, 0));
  EXPECT_THAT(counts(run_recede(others)), ElementsAre(0, 5, 0));
}

TEST_F(Batch, GoesOnAfterAFileThatFails) {
  folder_.write("ball200.ply", "ply\nnonsense\n");
  fs::remove(folder_ / "ball400.ply");
  const CommandResult run = run_recede(arguments());
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(counts(run), ElementsAre(3, 0, 2));
  EXPECT_THAT(run.remarks, HasSubstr("ball200.ply:2: unknown header line"));
  EXPECT_THAT(run.remarks, HasSubstr("ball400.ply: No such file or directory\n"));
  EXPECT_THAT(run.remarks, HasSubstr("recede: 2 of 5 assets failed\n"));
  EXPECT_FALSE(fs::exists(folder_ / "out/ball200"));
  write_soup(folder_ / "ball200.ply", make_displaced_sphere(200, true));
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(1, 3, 1));
}

TEST_F(Batch, SaysHowManyInText) {
  folder_.write("ball200.ply", "ply\nnonsense\n");
  std::vector<std::string> words = arguments();
  std::erase(words, "--json");
  EXPECT_EQ(run_recede(words).output, "baked 4, done before 0, failed 1\n");
}

TEST_F(Batch, ReadsItsListFromStandardInput) {
  EXPECT_EQ(complaint_of(run_recede({"batch", "-", "-o", folder_ / "out"}), 1),
            "recede: -: no files in this list");
}

TEST_F(Batch, FinishesWhatCtrlCLeft) {
  list_ = folder_.write("list.txt", text_ + "sphere\n");  // large enough to be interrupted
  std::vector<std::string> words = arguments();
  std::erase(words, "--json");
  const CommandResult run = run_recede_on_terminal(words, "5 of 6");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.output, HasSubstr("baked 5, done before 0, failed 0\r\n"));
  EXPECT_THAT(run.output, testing::EndsWith("recede: 1 of 6 assets are left\r\nrecede: cancelled\r\n"));
  EXPECT_FALSE(fs::exists(folder_ / "out/sphere/batch.json"));
  list_ = folder_.write("list.txt", text_);
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(0, 5, 0));
}

TEST_F(Batch, EndsAtOnceWhereOptionsAreWrong) {
  const CommandResult run =
      run_recede({"batch", list_.string(), "-o", folder_ / "out", "--", "--ratios", "0.1", "0.5"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("recede bake: "));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Batch, HasPartsThatMakeTheWhole) {
  std::vector<int> baked;
  for (const char* part : {"1/3", "2/3", "3/3"})
    baked.push_back(counts(run_recede(arguments({"--part", part}))).at(0));
  EXPECT_THAT(baked, ElementsAre(2, 2, 1));
  EXPECT_THAT(counts(run_recede(arguments())), ElementsAre(0, 5, 0));
  for (const char* wrong : {"0/3", "4/3", "3", "-1/3", "1/3x", "1:3"})
    EXPECT_THAT(complaint_of(run_recede(arguments({"--part", wrong})), 2), HasSubstr("--part"));
}

TEST_F(Batch, TellsTheLineOfAListThatIsWrong) {
  const auto complaint = [&](const std::string& text) {
    list_ = folder_.write("wrong.txt", text);
    return complaint_of(run_recede(arguments()), 1);
  };
  EXPECT_THAT(complaint("a/x.ply\nb/x.obj\n"),
              HasSubstr("wrong.txt, line 2: 'x' would go where line 1 goes"));
  EXPECT_THAT(complaint("a.ply\t../b\n"), HasSubstr("wrong.txt, line 1: '../b' can't be the name"));
  EXPECT_THAT(complaint("\tb\n"), HasSubstr("line 1: a name without a file"));
  EXPECT_THAT(complaint("# nothing\n"), HasSubstr("no files in this list"));
  list_ = folder_ / "missing.txt";
  EXPECT_THAT(complaint_of(run_recede(arguments()), 1), HasSubstr("missing.txt"));
}

TEST_F(Batch, EndsAFileThatTakesTooLong) {
  list_ = folder_.write("list.txt", "sphere\n" + text_);
  // No model is baked within a millisecond.
  const CommandResult run = run_recede(arguments({"--timeout", "0.001"}));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(counts(run), ElementsAre(0, 0, 6));
  EXPECT_THAT(run.remarks, HasSubstr("sphere: no end after 0.001 s"));
}

TEST_F(Batch, ResumesAfterItWasKilled) {
  run_recede(arguments({}, "whole"));
  const auto expected = contents(folder_ / "whole");
  // A name more each time, which is while something is written.
  const std::size_t n_names = n_names_below(folder_ / "whole");
  CommandResult run;
  int n_killed = 0;
  for (std::size_t n = 1; n < 2 * n_names && run.code != 0; ++n) {
    run =
        run_recede_and_kill(arguments({"--jobs", "2"}), [&] { return n_names_below(folder_ / "out") >= n; });
    n_killed += run.code != 0 ? 1 : 0;
    // What has its record is whole.
    for (const std::string& name : names_below(folder_ / "out")) {
      if (!name.ends_with("/batch.json")) continue;
      const std::string asset = fs::path(name).parent_path().string();
      for (const auto& [file, content] : expected) {
        if (!file.starts_with(asset + "/")) continue;
        EXPECT_EQ(read_whole_file(folder_ / "out" / file), content) << file;
      }
    }
  }
  EXPECT_GT(n_killed, 5);
  if (run.code != 0) run = run_recede(arguments());
  EXPECT_EQ(counts(run).at(2), 0);
  auto found = contents(folder_ / "out");
  // Processes that were killed leave the files that they hadn't finished beside those that they would have
  // become.
  std::erase_if(found, [](const auto& file) { return file.first.find(".part") != std::string::npos; });
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace recede::test
