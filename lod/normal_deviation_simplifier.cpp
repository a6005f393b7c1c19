#include <recede/lod/detail/simplifier.h>
namespace recede::detail {
std::unique_ptr<Simplifier> make_normal_deviation_simplifier(CornerTable table, const SimplifyOptions& options) { return make_quadric_simplifier(std::move(table), options); }
}
