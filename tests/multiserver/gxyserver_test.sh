#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# gxyserver_test.sh GALAXY BIN - the programs as a user runs them: the server under MPI, clients from the shell, how it
# stops, and what happens when a rank dies.
set -uo pipefail
galaxy=$(realpath "$1") bin=$(realpath "$2") tests=$(dirname "$(realpath "$0")")
folder=$(mktemp -d)
export XDG_RUNTIME_DIR=$folder/run
mkdir -m 700 "$XDG_RUNTIME_DIR"
cd "$folder" || exit 1
server=
failures=0
finish() {
  [[ -z $server ]] || kill -KILL "$server" 2>/dev/null
  rm -rf "$folder"
}
trap finish EXIT

check() {  # check NAME COMMAND...: the command succeeds
  local name=$1
  shift
  if "$@"; then echo "ok: $name"; else printf 'FAILED: %s\n' "$name"; cat server.log; failures=$((failures + 1)); fi
}
start() {  # start RANKS ARGS...: a server on a free port; sets server and port
  local ranks=$1
  shift
  rm -f port
  "$galaxy" serve -n "$ranks" --port 0 --port-file port --log-level "${level:-info}" "$@" >server.log 2>&1 &
  server=$!
  for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
  port=$(cat port)
}
ended() {  # ended SECONDS: the server has, within so long; sets status
  for _ in $(seq $(($1 * 10))); do
    if ! kill -0 "$server" 2>/dev/null; then wait "$server"; status=$?; server=; return 0; fi
    sleep 0.1
  done
  return 1
}
msdata() { "$bin/msdata" -P "$port" "$@"; }
# The ranks of the server that was started: children of its mpirun, which is the child of `galaxy serve`.
ranks_of() { pgrep -P "$(pgrep -P "$server")" gxyserver; }

"$bin/gxydata" radial -r 24 --array eightBalls eightBalls.vol >/dev/null

start 2 --backend embree
check EachRankSaysWhatItRendersWith test "$(grep -c 'rank [01]: backend embree, CPU' server.log)" = 2
check TokenIsForItsUserOnly test "$(stat -c %a "$XDG_RUNTIME_DIR/galaxy/$port.token")" = 600
check ItsLogNamesTheCommandForBrowsers grep -q "in a browser:     run: galaxy gui localhost:$port\$" server.log
check AndHasNoTicket bash -c "! grep -q 'ticket=' server.log"
check TheCommandPrintsAnAddressThatLetsIn bash -c \
  "env -u DISPLAY -u WAYLAND_DISPLAY '$galaxy' gui localhost:$port | grep -Eqx 'galaxy: open http://localhost:$port/#ticket=[A-Za-z0-9_-]{43}'"
check NoServerIsTold bash -c "! '$galaxy' gui localhost:1 2>error.txt && grep -q 'no ticket from localhost:1' error.txt"
check SoIsANonsensicalPlace bash -c "! '$galaxy' gui 'local host' 2>error.txt && grep -q 'expected HOST:PORT' error.txt"
exec 3<>"/dev/tcp/localhost/$port"
printf 'GET / HTTP/1.1\r\nHost: localhost:%s\r\nConnection: close\r\n\r\n' "$port" >&3
check ThePageIsServedOnTheSamePort grep -q 'HTTP/1.1 200 OK' <&3
exec 3>&-
check TheViewTokenIsForItsUserOnly test "$(stat -c %a "$XDG_RUNTIME_DIR/galaxy/$port.view.token")" = 600
check AndLooks bash -c "'$bin/msdata' -P $port --token-file '$XDG_RUNTIME_DIR/galaxy/$port.view.token' -c 'list;' | grep -q datasets"
check AndChangesNothing bash -c \
  "'$bin/msdata' -P $port --token-file '$XDG_RUNTIME_DIR/galaxy/$port.view.token' -c 'drop x;' 2>&1 | grep -q 'drop: it changes something.*view-only'"
check EmptyListing test "$(echo 'list;' | msdata)" = "  datasets:"
cat >import.txt <<'END'
import { "Datasets": [
  {
    "name": "eightBalls",
    "filename": "eightBalls.vol",
    "type": "Volume" } ]};
END
check ABareOkPrintsNothing test -z "$(msdata import.txt)"
check TheOtherClientSeesIt test "$(echo 'list;' | msdata)" = $'  datasets:\n  eightBalls'
check TheTerminalCompletesAndRemembers "$tests/terminal.py" "$bin/msdata" -P "$port"
check JsonIsALineForEachStatement test "$(echo 'range eightBalls; list' | msdata --json | grep -c '"ok":true')" = 2
check StatementsAreArguments test "$(msdata -c 'range eightBalls; list' -c 'drop nothing' --json 2>error.txt | wc -l)" = 3
check BeforeScripts test "$(echo 'list;' | msdata --json -c modules - | grep -o '"[a-z]*"}$' | tr -d '"}\n')" = moduleslist
check StatIsAWordOfItsOwn test "$(msdata stat --json | grep -c '"ledger".*"ledger".*"statement":"stat"')" = 1
echo 'list;' >stat
check UnlessAFileIsCalledSo test "$(msdata stat)" = $'  datasets:\n  eightBalls'
rm stat
echo 'drop nothing; list;' | msdata >out.txt 2>error.txt
check AFailedStatementIsSeenInTheExitCode test $? = 1
check AndTheNextOneRunsNevertheless grep -q eightBalls out.txt
msdata . 2>error.txt
check AFolderIsNoScript test $? = 2
msdata -c help >/dev/full 2>error.txt
check WhatCannotBePrintedIsAnError test $? = 2
printf '  # list;\nlist;' >commented.txt
check LinesOfCommentsMayBeIndented test "$(msdata commented.txt)" = $'  datasets:\n  eightBalls'
check AWrongTokenIsTold bash -c "echo wrong >wrong; ! '$bin/msdata' -P $port --token-file wrong import.txt 2>error.txt && grep -q 'token is wrong' error.txt"

# Events: told apart from replies, in the order in which they came, also to who waits for more input or has none.
seen='import {"Datasets": {"name": "seen", "type": "Volume", "filename": "eightBalls.vol"}}'
told() { grep -o '"\(event\|statement\)":"[a-z]*' | grep -v progress | cut -d '"' -f 2,4 | tr '"\n' ' ,'; }
check EventsAreLinesOfJsonAmongReplies test "$(msdata --json -c "observe; $seen; drop seen" | told)" = \
  "statement observe,event added,statement import,event dropped,statement drop,"
check ProgressIsLinesOfJsonToo test "$(msdata --json -c "$seen; drop seen" | grep -c '"event":"progress"')" -ge 1
check ForPeopleToo test "$(msdata -c "observe; $seen; drop seen" 2>&1)" = \
  $'event: added seen, private Volume, generation 1\nevent: dropped seen, private Volume, generation 1'
(echo 'observe; echo ready;'; for _ in $(seq 300); do [[ -e over ]] && break; sleep 0.1; done) | msdata >piped.txt &
piped=$!
"$bin/msdata" -P "$port" -c 'observe; echo ready' --follow >followed.txt &
follows=$!
came() { for _ in $(seq 300); do grep -q "$1" piped.txt && grep -q "$1" followed.txt && return; sleep 0.1; done; return 1; }
came ready
msdata -c "$seen; drop seen"
check WhoWaitsForInputOrFollowsIsTold came 'event: dropped seen'
touch over
kill "$follows"
wait "$piped" "$follows" 2>/dev/null

cat >scene.json <<'END'
{"Datasets": [{"name": "eightBalls", "type": "Volume", "filename": "eightBalls.vol"}],
 "Visualization": {"Lighting": {"shadows": true, "ao count": 2},
   "operators": [{"type": "Volume", "dataset": "eightBalls", "isovalues": [0.3]}]},
 "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "dimensions": [120, 90]}}
END
echo "batch {\"prefix\": \"served\", \"state\": $(cat scene.json)}" | "$bin/msclient" -P "$port" -m viewer >/dev/null
"$bin/gxyrender" scene.json -o alone >/dev/null 2>&1
check PicturesAreThoseOfGxyrender cmp served_00000.png alone_00000.png
sed 's/^{/{"Annotations": {"legend": true, "axes": true, "outline": true, "text": "balls"}, /;q' scene.json >annotated.json
sed 1d scene.json >>annotated.json
echo "batch {\"prefix\": \"annotated\", \"state\": $(cat annotated.json)}" | "$bin/msclient" -P "$port" -m viewer >/dev/null
"$bin/gxyrender" annotated.json -o annotated-alone >/dev/null 2>&1
check AlsoAnnotated cmp annotated_00000.png annotated-alone_00000.png
check WhichIsSeen bash -c '! cmp -s annotated_00000.png served_00000.png'

# A graph, by text alone.
cat >graph.txt <<'END'
graph.new fig {"Datasets": [{"name": "eightBalls", "type": "Volume"},
  {"name": "seeds", "filter": "Seeds", "inputs": {"domain": "eightBalls"}, "shape": "line", "count": 20}]};
graph.run fig; graph.wait fig;
graph.edit fig {"edits": [{"set": ["Datasets", "seeds", "count"], "to": 30}]};
graph.run fig seeds; graph.wait fig; list all; graph.drop fig
END
"$bin/msclient" -P "$port" -m data -m graph graph.txt >graph.out
check AGraphIsDrivenByStatements test "$(grep -c 'dataset seeds: done' graph.out)" = 2
check AndEdited grep -q 'revision 2' graph.out
check ItsOutputsHaveNames grep -q '^  fig/seeds' graph.out
check AndGoWithIt test "$(msdata -c 'list all')" = $'  datasets:\n  eightBalls'

mkdir -p there/pictures/blocked_00000.png
batch() {  # batch PREFIX: a picture to the client, in folder there/pictures
  (cd there/pictures && "$bin/msclient" -P "$port" -m viewer \
    -c "batch {\"to\": \"client\", \"prefix\": \"$1\", \"state\": $(cat ../../scene.json)}")
}
check PicturesThatComeAreWrittenHere test "$(batch ../sent)" = $'  wrote sent_00000.png\n  1 pictures'
check AndNowhereElse cmp there/pictures/sent_00000.png alone_00000.png
check WhateverTheirNames test ! -e there/sent_00000.png
batch blocked 2>error.txt
check OneThatCannotBeWrittenIsSeenInTheExitCode test $? = 1
check AndTold grep -q 'blocked_00000.png: cannot be written' error.txt

check QuitByTheAdministratorStopsIt bash -c "echo 'quit;' | '$bin/msdata' -P $port"
check InTime ended 10
check WithStatus0 test "$status" = 0
check AndTakesItsTokenAlong test ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"

level=debug start 1
token=$(cat "$XDG_RUNTIME_DIR/galaxy/$port.token")
check TheTokenIsThere test ${#token} = 64
check AndLetsIn test "$(echo 'list;' | msdata)" = "  datasets:"
echo "${token%?}x" >wrong
"$bin/msdata" -P "$port" --token-file wrong -c list 2>error.txt
kill -INT "$(ranks_of)"
check CtrlCStopsIt ended 10
check Cleanly test "$status" = 0 -a ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"
check TheLogDoesNotTellTheToken bash -c "grep -q 'listening on' server.log && ! grep -q '${token:0:16}' server.log"

start 1
kill -TERM "$(ranks_of)"
check TermStopsIt ended 10
check CleanlyToo test "$status" = 0 -a ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"

start 2
kill -TERM "$(ranks_of | tail -n 1)"
check TermToAnyRankStopsIt ended 10
check CleanlyToo test "$status" = 0 -a ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"

# The launcher brings what the server prints, perhaps after the server has written its port.
announced() {
  for _ in {1..200}; do
    grep -q "^gxyserver: $1:" server.log && break
    sleep 0.05
  done
  sed -n "s/^gxyserver: $1: *//p" server.log
}
start 1 --bind 127.0.0.3
check WhatIsAnnouncedHereConnects test "$(eval "echo 'list;' | '$bin'/$(announced 'on this machine')")" = "  datasets:"
check AndTheTunnelEndsThere grep -qF "ssh -N -L $port:127.0.0.3:$port " <(announced 'from elsewhere')
kill -TERM "$(ranks_of)"
ended 10
start 1 --token-file its-token
check SoItDoesWithATokenFile test "$(eval "echo 'list;' | '$bin'/$(announced 'on this machine')")" = "  datasets:"
kill -TERM "$(ranks_of)"
ended 10
start 1 --no-token --bind 0.0.0.0
check AndWithoutTokens test "$(eval "echo 'list;' | '$bin'/$(announced 'on this machine')")" = "  datasets:"
kill -TERM "$(ranks_of)"
ended 10

start 2 --trace trace.json
check ATraceIsBegunAtTheStart test -s trace.json
echo 'list;' | msdata >/dev/null
kill -TERM "$server"
check TermToGalaxyServeStopsIt ended 30
check CleanlyToo test "$status" = 0 -a ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"
check AndSaysSo grep -q 'gxyserver: stopped' server.log
check TheTraceTellsOfAllRanks python3 -c "
import json
events = json.load(open('trace.json'))['traceEvents']
names = {(e['pid'], e['name']) for e in events}
assert {(0, 'list'), (0, 'load'), (1, 'modules.open'), (1, 'message: work')} <= names, names"

# With work under way: windows that refine, a batch, an import. Ctrl-C comes to the process group.
set -m
start 2 --backend embree
set +m
"$bin/gxydata" radial -r 256 --array eightBalls large.vol >/dev/null
{
  printf 'load data; import {"Datasets": {"name": "eightBalls", "type": "Volume", "filename": "eightBalls.vol"}};\n'
  for window in 1 2 3 4; do
    printf 'window %s; set %s %s; render %s {"passes": 500};\n' $window $window "$(cat scene.json)" $window
  done
  printf 'echo ready; batch {"prefix": "busy", "state": %s};\n' "$(sed 's/"Camera": {.*}/"Cameras": [{"dimensions": [400, 300]}]/' scene.json)"
} >busy.txt
"$bin/msclient" -P "$port" -m viewer busy.txt >busy.log 2>&1 &
busy=$!
msdata -c 'import {"Datasets": {"name": "large", "type": "Volume", "filename": "large.vol"}}' >/dev/null 2>&1 &
importing=$!
for _ in $(seq 300); do grep -q ready busy.log && break; sleep 0.1; done
kill -INT -- "-$server"
check CtrlCStopsAServerThatWorks ended 60
check CleanlyToo test "$status" = 0 -a ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"
check AndSaysSo grep -q 'gxyserver: stopped' server.log
wait "$busy" "$importing"

start 2
launcher=$(pgrep -P "$server")
kill -KILL "$server"
server=
gone() { for _ in $(seq 300); do kill -0 "$launcher" 2>/dev/null || return 0; sleep 0.1; done; return 1; }
check ItStopsWhenGalaxyServeIsKilled gone
check AndTakesItsTokenAlong test ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"

process_of() {  # process_of RANK
  local process
  for process in $(ranks_of); do
    ! tr '\0' '\n' <"/proc/$process/environ" | grep -qx "OMPI_COMM_WORLD_RANK=$1" || echo "$process"
  done
}
for rank in 0 1; do
  start 3
  rm -f followed.txt  # of the client before: it is ready, too
  "$bin/msdata" -P "$port" -c 'echo ready' --follow >followed.txt 2>error.txt &
  follows=$!
  for _ in $(seq 300); do grep -qs ready followed.txt && break; sleep 0.1; done
  began=$SECONDS
  kill -KILL "$(process_of $rank)"
  check ADeadRankTakesTheRunDown ended 5
  check WithAnError test "$status" != 0
  check AndSaysWhichAndWhy grep -Eq 'rank [0-9]+ .*signal 9' server.log
  check WithinFiveSeconds test $((SECONDS - began)) -le 5
  wait "$follows"
  check ItsClientsAreToldOfTheEnd grep -q 'the connection has ended: ' error.txt
  [[ $rank = 0 ]] || check AndWhichRankHasDied grep -q 'the server stops: rank 1 has died' error.txt
  check TheTokenHasGone test ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"
done

# A rank that is stopped: others answer, work waits for it and goes on with it, or the administrator ends the run.
start 3 --rank-patience 3
msdata -c list >/dev/null  # module data is there
kill -STOP "$(process_of 1)"
msdata stat >out.txt
check ARankThatDoesNotAnswerIsNamed grep -q '^  rank 1 \(has not answered for\|does not answer\)' out.txt
check AndTheOthersAnswer test "$(grep -c '^  rank [02]: .* resident' out.txt)" = 2
"$bin/msdata" -P "$port" -c "$seen" 2>error.txt &
importing=$!
said() { for _ in $(seq 300); do grep -q "$1" error.txt && return; sleep 0.1; done; return 1; }
check WhoWaitsIsTold said 'waiting: rank 1 has not answered for'
kill -CONT "$(process_of 1)"
check AndAllGoesOn wait "$importing"
kill -STOP "$(process_of 1)"
check AnAdministratorCanEndTheRun "$bin/msclient" -P "$port" -c quit
check ByForce ended 20
check WithAnError test "$status" != 0
check AndItsReason grep -q 'rank 1 has not answered for .*, so the run is ended by force' server.log
check TheTokenHasGone test ! -e "$XDG_RUNTIME_DIR/galaxy/$port.token"

# A server of which nobody is left, as after kill -9 of all, or of the machine's out-of-memory killer.
start 1
launcher=$(pgrep -P "$server") rank=$(ranks_of)
kill -STOP "$server" "$launcher"  # so that none of them tells the rank to stop before it is dead
kill -KILL "$rank" "$launcher" "$server"
server=
check ATokenIsLeft test -s "$XDG_RUNTIME_DIR/galaxy/$port.token"
start 2
check AndTheNextServerRemovesIt test "$(ls "$XDG_RUNTIME_DIR/galaxy")" = "$port.token"$'\n'"$port.view.token"
other=$port
rm -f port
"$galaxy" serve -n 2 --port "$other" >second.log 2>&1
check APortInUseIsAnErrorOnAllRanks test $? != 0
check AndSaysSo grep -q "cannot listen on 127.0.0.1 port $other" second.log
check AFolderThatIsNotThereIsAnErrorToo bash -c "! '$galaxy' serve --port 0 --data nowhere >third.log 2>&1 && grep -q nowhere third.log"
check SoIsOneOfModules bash -c "! '$galaxy' serve --port 0 --modules /nonexistent >fifth.log 2>&1 && grep -q '/nonexistent: it is no folder' fifth.log"
check SoIsADeviceThatIsNotThere bash -c "! '$galaxy' serve --port 0 --device nosuch >fourth.log 2>&1 && grep -q 'device \"nosuch\"' fourth.log"
check SoIsAnotherAddressOnItsPort bash -c "! '$galaxy' serve --bind 127.0.0.2 --port '$other' >sixth.log 2>&1 && grep -q '$other.token: a server that runs has its token there' sixth.log"
check SoIsATraceThatCannotBeWritten bash -c "! '$galaxy' serve --port 0 --trace nowhere/t >seventh.log 2>&1 && grep -q 'nowhere/t: ' seventh.log"
port=$other
check AndTheTokenOfTheOneThatRunsStays test -s "$XDG_RUNTIME_DIR/galaxy/$port.token"
echo 'quit;' | msdata
ended 10
start 1 --tenant-memory 20000
check ATenantHasTheMemoryThatIsSaid bash -c "! '$bin/msdata' -P $port -c '$seen' 2>error.txt"
check AndIsToldHowMuch grep -q "of tenant .*'s 20000 bytes" error.txt
echo 'quit;' | msdata
ended 10
mkdir modules
start 1 --modules modules
check ModulesOfOnesOwnComeBesideGalaxys test "$(echo 'list;' | msdata)" = "  datasets:"
echo 'quit;' | msdata
ended 10

# At a terminal, the address lets in at once.
rm -f port
script -qefc "'$galaxy' serve --port 0 --port-file port --no-gui" /dev/null >none.tty 2>&1 </dev/null &
for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
port=$(cat port)
echo 'quit;' | msdata
wait $!
check NoGuiIsNotAnnounced bash -c "! grep -q 'in a browser' none.tty"
rm -f port
script -qefc "'$galaxy' serve --port 0 --port-file port" /dev/null >serve.tty 2>&1 </dev/null &
for _ in $(seq 300); do [[ -s port ]] && break; sleep 0.1; done
port=$(cat port)
echo 'quit;' | msdata
wait $!
check AtATerminalTheAddressHasATicket grep -Eq "in a browser:     open http://localhost:$port/#ticket=[A-Za-z0-9_-]{43}" serve.tty

for program in msdata msclient; do
  "$bin/$program" --nosuch 2>error.txt
  check "WrongUsageOf${program}IsStatus2" test $? = 2
done
wrong() {  # wrong NAME WORDS OPTIONS...: gxyserver refuses its options with status 2 and a message with these words
  local name=$1 words=$2
  shift 2
  "$bin/gxyserver" "$@" >/dev/null 2>error.txt
  check "$name" test $? = 2
  check AndSaysWhatIsExpected grep -q -- "$words" error.txt
}
wrong NoMemoryIsWrongUsage '--memory: expected bytes from 1 up, as 500M, found 0$' --memory 0
wrong SoIsLess 'expected bytes from 1 up\|found -5' --memory -5
wrong SoIsATenantTwice "--tenant: expected each tenant once, found 'bob' again" --tenant bob --tenant ann --tenant bob
wrong SoIsOneOfTheLedgersNames 'expected another name than server' --tenant server
wrong SoIsOneOfViewOnlyTokens "does not end in '.view'" --tenant bob.view
wrong SoIsAHostWithAPort "--host: expected a host's name or address without a port" --host viz.example.org:80
wrong SoIsAGuiThatIsNotThere '--gui: Directory does not exist: nowhere' --gui nowhere
wrong SoIsAPath 'expected a name without /' --tenant a/b
"$bin/msdata" -H 192.0.2.1 -c list 2>error.txt
check NoTokenGoesElsewhereByItself test $? = 2
check AndThatIsSaid grep -q 'another machine.*--token-file' error.txt
check TheHelpSaysHowMuchMemory grep -Eq -- '--memory [^ ]* [^-]*=8G ' <("$bin/gxyserver" --help | tr -s ' \n' ' ')
exit $((failures > 0))
