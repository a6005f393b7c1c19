#include "billboard_run.h"

namespace recede::bench {

BenchSection measure_billboards(const BenchOptions& options) {
  return run_sections(options, "Billboard clouds", "billboards",
                      {{"growth", measure_billboard_growth},
                       {"counts", measure_billboard_counts},
                       {"planes", measure_plane_counts, false},
                       {"outlines", measure_outlines, false},
                       {"relit", measure_relit, false},
                       {"atlases", measure_atlases, false},
                       {"far levels", measure_far_levels}});
}

}  // namespace recede::bench
