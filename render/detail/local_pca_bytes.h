// Local PCA as the bytes of its file, for files that hold more than one.
#pragma once

#include <recede/render/local_pca.h>

#include <string>
#include <string_view>

namespace recede::detail {

/// As `write_local_pca` writes them; `name` is for `InputError`.
std::string bytes_of(const LocalPca& pca, const std::string& name);

/// Throws `InputError` with `name` for anything else.
LocalPca local_pca_of(std::string_view bytes, const std::string& name);

}  // namespace recede::detail
