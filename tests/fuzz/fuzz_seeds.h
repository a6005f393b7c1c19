// Small files of each kind, from which a fuzzer starts.
#pragma once

#include <filesystem>

namespace recede::test {

/// Files into a folder that is there, of all that the reader takes by that extension.
void seed_soup(const std::filesystem::path& folder, const char* extension);
void seed_pmesh(const std::filesystem::path& folder, const char* extension);
void seed_shell(const std::filesystem::path& folder, const char* extension);
void seed_image(const std::filesystem::path& folder, const char* extension);
void seed_jpeg(const std::filesystem::path& folder, const char* extension);
void seed_hierarchy(const std::filesystem::path& folder, const char* extension);
void seed_pca(const std::filesystem::path& folder, const char* extension);
void seed_appearance(const std::filesystem::path& folder, const char* extension);
void seed_reflectance(const std::filesystem::path& folder, const char* extension);
void seed_reflectance_table(const std::filesystem::path& folder, const char* extension);
void seed_scattering_table(const std::filesystem::path& folder, const char* extension);

/// With its levels; returns its own folder.
std::filesystem::path write_small_hierarchy(const std::filesystem::path& folder);

}  // namespace recede::test
