// SPDX-License-Identifier: Apache-2.0
#include "core/comm/mpi_environment.h"

#include <mpi.h>
#include <unistd.h>

#include <cstdlib>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/comm/error.h"

namespace gxy {
namespace {

/// Whether mpirun, srun or another launcher started this process. The environment variables that they set for
/// MPI tell.
bool launched() {
  for (char** entry = environ; *entry; entry++)
    for (const std::string_view prefix :
         {"OMPI_COMM_", "PMIX_", "PMI_", "PMI2_", "SLURM_", "HYDRA_", "FLUX_", "JSM_", "ALPS_"})
      if (std::string_view(*entry).starts_with(prefix)) return true;
  return false;
}

/// Sets variables of Open MPI and hwloc while MPI is initialised in a process that no launcher started, which
/// therefore is a job of one rank. Without them Open MPI would start a daemon and load modules that move data
/// between processes, and hwloc would look for displays and GPUs. Open MPI would also make a directory that
/// has the same name for every such process, and first remove what it finds there, so that processes which
/// start at the same time fail. Variables that the user has set stay as they are. The destructor removes the
/// others, so that programs that this one starts do not see them.
class SettingsOfOneRank {
 public:
  SettingsOfOneRank() {
    if (launched()) return;
    for (const auto& [name, value] : std::initializer_list<std::pair<const char*, const char*>>{
             {"OMPI_MCA_ess_singleton_isolated", "1"},
             {"OMPI_MCA_pml", "ob1"},
             {"OMPI_MCA_btl", "self"},
             {"OMPI_MCA_mtl", "^ofi,psm,psm2"},
             {"OMPI_MCA_coll", "basic,inter,libnbc,self"},
             {"OMPI_MCA_osc", "^monitoring,pt2pt,rdma,sm,ucx"},
             {"OMPI_MCA_schizo", "ompi,orte"},
             {"OMPI_MCA_orte_create_session_dirs", "0"},
             {"HWLOC_PLUGINS_PATH", "/dev/null"}}) {
      if (std::getenv(name)) continue;
      setenv(name, value, 1);
      set_.push_back(name);
    }
  }
  ~SettingsOfOneRank() {
    for (const char* name : set_) unsetenv(name);
  }
  SettingsOfOneRank(const SettingsOfOneRank&) = delete;
  SettingsOfOneRank& operator=(const SettingsOfOneRank&) = delete;

 private:
  std::vector<const char*> set_;
};

}  // namespace

MpiEnvironment::MpiEnvironment(bool beside) {
  const int needed = beside ? MPI_THREAD_MULTIPLE : MPI_THREAD_SERIALIZED;
  int initialised = 0, level = 0;
  MPI_Initialized(&initialised);
  if (initialised) {
    MPI_Query_thread(&level);
  } else {
    const SettingsOfOneRank settings;
    MPI_Init_thread(nullptr, nullptr, needed, &level);
    finalises_ = true;
  }
  if (level >= needed) return;
  if (finalises_) MPI_Finalize();
  throw Error("MPI runs with thread level " + std::to_string(level) + ", expected " +
              (beside ? "" : "MPI_THREAD_SERIALIZED, or ") +
              "MPI_THREAD_MULTIPLE when the host program calls MPI as well");
}

MpiEnvironment::~MpiEnvironment() {
  if (finalises_) MPI_Finalize();
}

}  // namespace gxy
