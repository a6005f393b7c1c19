#include "billboard_run.h"

namespace recede::bench {

std::string billboard_tables(const BenchOptions& options) {
  return section_tables(options, "Billboard clouds", "billboards",
                        {{"growth", measure_billboard_growth},
                         {"counts", measure_billboard_counts},
                         {"planes", measure_plane_counts},
                         {"outlines", measure_outlines},
                         {"relit", measure_relit},
                         {"atlases", measure_atlases},
                         {"far levels", measure_far_levels}});
}

}  // namespace recede::bench
