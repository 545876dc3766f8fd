#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# galaxy_script.sh GALAXY - how tools/galaxy starts programs and answers wrong usage. mpirun and srun are stand-ins that
# print their arguments, except in the last test.
set -uo pipefail
galaxy=$1
stand_ins=$(mktemp -d)
trap 'rm -rf "$stand_ins"' EXIT
failures=0

printf '#!/bin/sh\n[ "$1" = --version ] && echo "mpirun (Open MPI) 4.1.4" || echo "mpirun $*"\n' >"$stand_ins/mpirun"
printf '#!/bin/sh\n[ "$1" = --mpi=list ] && echo "none $PLUGINS" || echo "srun $*"\n' >"$stand_ins/srun"
chmod +x "$stand_ins"/*
with_stand_ins() { env -u SLURM_JOB_ID PATH="$stand_ins:$PATH" "$@"; }

# expect NAME STATUS PATTERN COMMAND...: the command ends with the status and prints something the pattern matches.
expect() {
  local name=$1 wanted=$2 pattern=$3 output status
  shift 3
  output=$("$@" 2>&1 </dev/null)
  status=$?
  if [[ $status == "$wanted" && $output =~ $pattern ]]; then
    echo "ok: $name"
  else
    printf 'FAILED: %s: exit status %s, expected %s; output, expected to match "%s":\n%s\n' \
      "$name" "$status" "$wanted" "$pattern" "$output"
    failures=$((failures + 1))
  fi
}

expect HelpNamesTheTwoCommands 0 'demo.*test' "$galaxy" --help
expect UnknownCommandIsAnsweredByTheNearest 2 'unknown command dmo; did you mean demo\?' "$galaxy" dmo
expect AlsoWhereThatIsTwoLettersAway 2 'did you mean test\?' "$galaxy" tset
expect UnknownCommandFarFromAllIsWrongUsage 2 'unknown command rendering$' "$galaxy" rendering
expect VersionIsPrinted 0 '^galaxy [0-9]+\.[0-9]+\.[0-9]+$' "$galaxy" --version
expect UnknownOptionOfRunIsWrongUsage 2 'run: unknown option --fast' "$galaxy" run --fast true
expect UnknownOptionOfDemoIsWrongUsage 2 'demo: unknown option --fast' "$galaxy" demo insitu --fast
expect UnknownOptionIsWrongUsage 2 'unknown option --fast' "$galaxy" test --fast
expect MissingValueIsWrongUsage 2 'a value is missing' "$galaxy" test -R
expect JobsMustBeANumber 2 'expected a number' "$galaxy" build --jobs many
expect RanksMustBePositive 2 'expected a number' "$galaxy" run -n 0 true
expect ProgramMustExist 2 'no program nosuchprogram' "$galaxy" run nosuchprogram
expect RanksAreNotPinnedToCores 0 '^mpirun -np 4 .*--bind-to none .*true x$' with_stand_ins "$galaxy" run -n 4 true x
expect MoreRanksThanCoresAreAllowed 0 ':OVERSUBSCRIBE' with_stand_ins "$galaxy" run true
expect WaitingRanksYield 0 'mpi_yield_when_idle 1' with_stand_ins "$galaxy" run true
expect OwnFlagsArePassedOn 0 '--hostfile nodes true' with_stand_ins "$galaxy" run --mpi '--hostfile nodes' true
expect SlurmStartsItsOwn 0 '^srun --ntasks 8 --kill-on-bad-exit=1 true$' with_stand_ins env SLURM_JOB_ID=1 "$galaxy" run -n 8 true
expect SlurmRanksFindEachOther 0 '^srun .*--mpi=pmix true$' with_stand_ins env SLURM_JOB_ID=1 PLUGINS=pmix_v4 "$galaxy" run true
expect SlurmKeepsTheMpiThatTheUserChose 0 '^srun --ntasks 1 --kill-on-bad-exit=1 true$' \
  with_stand_ins env SLURM_JOB_ID=1 PLUGINS=pmix_v4 SLURM_MPI_TYPE=pmi2 "$galaxy" run true
expect StatusOfTheProgramIsKept 7 '' "$galaxy" run -n 2 sh -c 'exit 7'
expect RanksAreReallyStarted 0 'rank.*rank.*rank' "$galaxy" run -n 3 echo rank
exit $((failures > 0))
