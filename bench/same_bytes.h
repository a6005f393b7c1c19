// Fingerprints of results for one and for two threads.
#pragma once

#include <filesystem>
#include <string>

namespace recede::bench {

/// A Markdown table of ten models, simplified to 10 % of their faces: 64-bit FNV-1a hashes of all bytes of
/// the result. `data` is the folder of `./dev data`.
std::string same_bytes_table(const std::filesystem::path& data);

}  // namespace recede::bench
