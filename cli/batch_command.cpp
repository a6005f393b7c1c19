#include "child_process.h"
#include "common.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/version.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <list>
#include <map>
#include <sstream>
#include <thread>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

struct BatchOptions {
  CommonOptions common;
  std::string list, output;
  std::vector<std::string> bake;  // arguments of `recede bake`
  std::size_t jobs = 1;
  std::array<std::size_t, 2> part{1, 1};
  double timeout = 0;  // seconds; 0: none
  bool again = false;
};

struct Asset {
  std::string input;
  fs::path folder;
};

/// What a finished asset was made from and how. Equal records: nothing is to be done.
Json origin_of(const Asset& asset, const BatchOptions& options) {
  std::error_code is_no_file;  // a built-in model, or a file that isn't there
  const auto bytes = fs::file_size(asset.input, is_no_file);
  if (is_no_file) return {{"input", asset.input}, {"version", RECEDE_VERSION}, {"arguments", options.bake}};
  const auto modified = fs::last_write_time(asset.input).time_since_epoch();
  return {{"input", asset.input},
          {"input_bytes", bytes},
          {"input_modified", std::chrono::duration_cast<std::chrono::nanoseconds>(modified).count()},
          {"version", RECEDE_VERSION},
          {"arguments", options.bake}};
}

/// Written when all else of an asset is there.
fs::path record_file(const Asset& asset) { return asset.folder / "batch.json"; }

bool is_done(const Asset& asset, const BatchOptions& options) {
  if (options.again || !fs::exists(record_file(asset))) return false;
  const Json record = Json::parse(read_whole_file(record_file(asset)), nullptr, false);
  return record.is_object() && record.contains("origin") &&
         text_of(record["origin"]) == text_of(origin_of(asset, options));
}

std::string text_of_list(const std::string& list) {
  if (list != "-") return read_whole_file(list);
  return {std::istreambuf_iterator<char>(std::cin), {}};
}

/// A file a line, with the name of its folder after a tab where that isn't the file's own. Empty lines and
/// those that begin with # mean nothing.
std::vector<Asset> read_list(const BatchOptions& options) {
  std::vector<Asset> assets;
  std::map<fs::path, std::size_t> line_of;  // of the first asset with this folder
  std::istringstream lines(text_of_list(options.list));
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (line.ends_with('\r')) line.pop_back();
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t tab = line.find('\t');
    const std::string input = line.substr(0, tab);
    const fs::path name = tab == line.npos ? fs::path(input).stem() : fs::path(line.substr(tab + 1));
    const auto refuse = [&](const std::string& reason) {
      throw InputError(fmt::format("{}, line {}: {}", options.list, number, reason));
    };
    if (input.empty()) refuse("a name without a file");
    if (name.empty() || name.is_absolute() || std::count(name.begin(), name.end(), "..") > 0)
      refuse(fmt::format("'{}' can't be the name of a folder below {}", name.string(), options.output));
    const auto [same, is_new] = line_of.emplace(name.lexically_normal(), number);
    if (!is_new) {
      refuse(fmt::format("'{}' would go where line {} goes; write another name after a tab", name.string(),
                         same->second));
    }
    assets.push_back({input, fs::path(options.output) / name});
  }
  return assets;
}

/// Every `count`th asset, so that neighbours in the list, which are often alike, go to different parts.
std::vector<Asset> part_of(const std::vector<Asset>& assets, std::size_t part, std::size_t count) {
  std::vector<Asset> chosen;
  for (std::size_t i = part - 1; i < assets.size(); i += count) chosen.push_back(assets[i]);
  return chosen;
}

std::array<std::size_t, 2> parse_part(const std::string& text) {
  std::array<std::size_t, 2> part{};
  char slash = 0;
  std::istringstream in(text);
  const bool is_read = static_cast<bool>(in >> part[0] >> slash >> part[1]) && in.eof();
  if (!is_read || slash != '/' || text.starts_with('-') || part[0] < 1 || part[0] > part[1])
    throw OptionError("--part: " + text + " isn't like 3/8, the third of eight parts");
  return part;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Bakes assets in processes of their own, so that one that fails, even by a crash, costs no other.
class Batch {
 public:
  Batch(std::vector<Asset> assets, const BatchOptions& options)
      : assets_(std::move(assets)),
        options_(options),
        program_(own_program()),
        progress_(options.common.quiet) {}

  void run() {
    for (const Asset& asset : assets_) {
      if (progress_.cancel_requested()) break;
      if (is_done(asset, options_)) {
        ++done_before_;
        report(asset, {{"state", "done before"}});
        continue;
      }
      while (running_.size() >= options_.jobs) wait_for_one();
      if (progress_.cancel_requested()) break;
      start(asset);
    }
    while (!running_.empty()) wait_for_one();
    progress_.clear();
    print();
    const std::size_t left = assets_.size() - done_before_ - baked_ - failed_;
    if (left > 0) {
      print_remark(fmt::format("{} of {} assets are left", left, assets_.size()), options_.common);
      throw Cancelled();
    }
    if (failed_ > 0) throw InputError(fmt::format("{} of {} assets failed", failed_, assets_.size()));
  }

 private:
  struct Job {
    const Asset* asset;
    std::unique_ptr<ChildProcess> process;
    Json origin;  // as it was when the process began
    bool is_late = false;
  };

  void start(const Asset& asset) {
    std::vector<std::string> words{program_, "bake", asset.input, "-o", asset.folder.string(), "--json"};
    words.insert(words.end(), options_.bake.begin(), options_.bake.end());
    words.insert(words.end(), {"--threads", std::to_string(threads_of_a_job())});
    Json origin = origin_of(asset, options_);
    fs::remove(record_file(asset));  // of other options: from here on the folder is neither
    running_.push_back({&asset, std::make_unique<ChildProcess>(words), std::move(origin)});
  }

  /// 0: all.
  std::size_t threads_of_a_job() const {
    if (options_.common.threads > 0) return static_cast<std::size_t>(options_.common.threads);
    if (options_.jobs == 1) return 0;
    return std::max<std::size_t>(1, std::thread::hardware_concurrency() / options_.jobs);
  }

  void wait_for_one() {
    constexpr auto k_interval = std::chrono::milliseconds(10);
    for (;; std::this_thread::sleep_for(k_interval)) {
      if (progress_.cancel_requested() && !is_cancelling_) {
        for (const Job& job : running_) job.process->send(SIGTERM);
        is_cancelling_ = true;
      }
      for (auto job = running_.begin(); job != running_.end(); ++job) {
        if (options_.timeout > 0 && job->process->seconds() > options_.timeout && !job->is_late) {
          job->process->send(SIGKILL);
          job->is_late = true;
        }
        const std::optional<ChildResult> result = job->process->poll();
        if (!result) continue;
        finish(*job, *result);
        running_.erase(job);
        return;
      }
      const std::size_t ended = done_before_ + baked_ + failed_;
      progress_.update(fmt::format("{} of {}", ended, assets_.size()),
                       static_cast<double>(ended) / static_cast<double>(assets_.size()));
    }
  }

  void finish(const Job& job, const ChildResult& result) {
    constexpr int k_wrong_usage = 2;
    const std::vector<std::string> remarks = lines_of(result.remarks);
    if (result.code == 0) return keep(job, result, remarks);
    if (is_cancelling_) return;  // as if it hadn't begun
    std::string reason = remarks.empty() ? "" : remarks.back();
    if (reason.starts_with("recede: ")) reason.erase(0, reason.find(' ') + 1);
    // The first one: the others would be refused, too.
    if (result.code == k_wrong_usage && baked_ + failed_ == 0) throw OptionError("recede bake: " + reason);
    if (job.is_late)
      reason = fmt::format("no end after {:g} s", options_.timeout);
    else if (result.code > 128)
      reason = fmt::format("ended by signal {}", result.code - 128);
    // Most reasons begin with the file.
    if (!reason.starts_with(job.asset->input)) reason = job.asset->input + ": " + reason;
    ++failed_;
    progress_.clear();
    fmt::print(stderr, "recede: {}\n", reason);
    report(*job.asset, {{"state", "failed"}, {"reason", reason}, {"seconds", result.seconds}});
  }

  void keep(const Job& job, const ChildResult& result, const std::vector<std::string>& remarks) {
    const Json record = {{"origin", job.origin},
                         {"seconds", result.seconds},
                         {"peak_bytes", result.peak_bytes},
                         {"remarks", remarks},
                         {"result", Json::parse(result.output)}};
    write_file_atomically(record_file(*job.asset), text_of(record));
    ++baked_;
    report(*job.asset, {{"state", "baked"}, {"seconds", result.seconds}, {"peak_bytes", result.peak_bytes}});
  }

  void report(const Asset& asset, const Json& what) {
    Json entry = {{"input", asset.input}, {"folder", asset.folder.string()}};
    entry.update(what);
    entries_.push_back(std::move(entry));
  }

  void print() const {
    if (options_.common.json) {
      print_json({{"command", "batch"},
                  {"list", options_.list},
                  {"baked", baked_},
                  {"done_before", done_before_},
                  {"failed", failed_},
                  {"assets", entries_}});
    } else {
      fmt::print("baked {}, done before {}, failed {}\n", baked_, done_before_, failed_);
    }
  }

  std::vector<Asset> assets_;
  const BatchOptions& options_;
  std::string program_;
  TerminalProgress progress_;
  std::list<Job> running_;
  Json entries_ = Json::array();
  std::size_t done_before_ = 0, baked_ = 0, failed_ = 0;
  bool is_cancelling_ = false;
};

void run(const BatchOptions& options) {
  check_output_folder(options.output);
  const std::vector<Asset> assets = read_list(options);
  if (assets.empty()) throw InputError(options.list + ": no files in this list");
  Batch(part_of(assets, options.part[0], options.part[1]), options).run();
}

}  // namespace

void add_batch_command(CLI::App& app) {
  const auto options = std::make_shared<BatchOptions>();
  CLI::App* command = app.add_subcommand(
      "batch",
      "Bakes the files of a list, each into a folder of its own; what is done already stays as it is.");
  command->footer(
      "Examples:\n  recede batch assets.txt -o baked/ -- --ratios 0.5 0.1\n"
      "  recede batch assets.txt -o baked/ --part 3/8     one of eight machines");
  command->add_option("list", options->list, "text with a file a line; -: standard input")->required();
  command->add_option("bake-options", options->bake, "options of recede bake, after --")
      ->option_text("-- ...");
  command->add_option("-o,--output", options->output, "folder for the assets' folders")->required();
  command->add_option("-j,--jobs", options->jobs, "files at once (1)")->check(between(1, 1024));
  command
      ->add_option_function<std::string>(
          "--part", [options](const std::string& text) { options->part = parse_part(text); },
          "3/8: the third of eight parts of the list")
      ->option_text("K/N");
  command->add_option("--timeout", options->timeout, "seconds for a file; 0 (default): as long as it takes")
      ->check(not_negative());
  command->add_flag("--again", options->again, "bake what is done already, too");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
