// The command line of recede_bench.
#pragma once

#include "report_run.h"

namespace recede::bench {

/// Writes a report of the sections that the arguments choose and names its file on stdout. Returns the exit
/// code: 0 when every section gave its results, 1 when one failed, and CLI11's for arguments that can't be
/// read.
int run_bench_command(const std::vector<ReportSection>& sections, int argc, const char* const* argv);

}  // namespace recede::bench
