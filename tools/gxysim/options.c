/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/gxysim/gxysim.h"

static const char help[] =
    "gxysim SIMULATION [OPTIONS]: a small simulation that publishes its steps to Galaxy. Start it under "
    "mpirun.\n"
    "GALAXY_INSITU=HOST:PORT says where to, and GALAXY_INSITU_OPTIONS=FILE.json more (docs/insitu.md).\n"
    "GALAXY_INSITU=here runs a server in these processes.\n\n"
    "  heat       heat conduction in a box with a warm floor and two hot balls: NAME.temperature, of points\n"
    "  blobs      clouds in two eddies: NAME.density and NAME.velocity, of cells\n"
    "  particles  bodies that orbit a mass: NAME.speed and NAME.velocity, of points\n\n"
    "  --size N | NXxNYxNZ   points of heat, cells of blobs (default: 64), or the number of particles "
    "(10000)\n"
    "  --blocks AxBxC        ranks along x, y and z (default: as MPI_Dims_create finds)\n"
    "  --steps N             steps to compute (default: 100)\n"
    "  --every N             publish every Nth step, and the last (default: 1)\n"
    "  --name NAME           name of the stream (default: that of the simulation)\n"
    "  --seconds-per-step S  pause so long after each step (default: 0)\n"
    "  --last S              wait at most so long for the last step to be published; 0: not at all (default: "
    "10)\n"
    "  --start sine          heat only: a sine mode that decays, and nothing that warms\n"
    "  --output FILE.npy     write the last step: temperature or density by z, y and x; position and "
    "velocity of\n"
    "                        each particle\n"
    "  --world               ranks of `gxyserver --world` are in the same MPI job\n"
    "  --help, --version     this text; the version\n\n"
    "The results are the same on all numbers of ranks, to the bit.\n"
    "Exit status: 0 done, 1 failed, 2 wrong usage. That there is no server is no failure.\n";

/* Reads a number from `least` to `most`. */
static int number(const char* text, double least, double most, double* value) {
  char* end;
  *value = strtod(text, &end);
  return end != text && *end == '\0' && *value >= least && *value <= most;
}

static int whole(const char* text, double most, int64_t* value) {
  double read;
  if (strspn(text, "0123456789") != strlen(text) || !number(text, 1, most, &read)) return 0;
  *value = (int64_t)read;
  return 1;
}

/* Reads AxBxC, each from 1 to `most`. */
static int triple(const char* text, double most, int64_t value[3]) {
  char part[3][16] = {"", "", ""};
  int end = 0;
  if (sscanf(text, "%15[0-9]x%15[0-9]x%15[0-9]%n", part[0], part[1], part[2], &end) != 3 || text[end] != '\0')
    return 0;
  return whole(part[0], most, &value[0]) && whole(part[1], most, &value[1]) &&
         whole(part[2], most, &value[2]);
}

/* Returns what was expected of the option's value, or NULL if it is that. */
static const char* take(const char* option, const char* value, gxysim_options* o) {
  const int particles = strcmp(o->simulation, "particles") == 0;
  if (strcmp(option, "--size") == 0) {
    if (particles) return whole(value, 1e9, &o->size[0]) ? NULL : "a number of particles";
    if (triple(value, 1e5, o->size)) return NULL;
    if (!whole(value, 1e5, &o->size[0])) return "a whole number, or three as in 64x48x32";
    o->size[1] = o->size[2] = o->size[0];
  } else if (strcmp(option, "--blocks") == 0) {
    int64_t blocks[3];
    if (!triple(value, 1e5, blocks)) return "three whole numbers, as in 2x2x1";
    for (int a = 0; a < 3; a++) o->blocks[a] = (int)blocks[a];
  } else if (strcmp(option, "--steps") == 0) {
    return whole(value, 1e12, &o->steps) ? NULL : "a whole number from 1";
  } else if (strcmp(option, "--every") == 0) {
    return whole(value, 1e12, &o->every) ? NULL : "a whole number from 1";
  } else if (strcmp(option, "--seconds-per-step") == 0) {
    return number(value, 0, 1e6, &o->pause) ? NULL : "seconds, from 0 to 1e6";
  } else if (strcmp(option, "--last") == 0) {
    return number(value, 0, 1e6, &o->last) ? NULL : "seconds, from 0 to 1e6";
  } else if (strcmp(option, "--start") == 0) {
    o->sine = strcmp(o->simulation, "heat") == 0 && strcmp(value, "sine") == 0;
    return o->sine ? NULL : "sine, and the simulation heat";
  } else if (strcmp(option, "--name") == 0) {
    o->name = value;
    return *value ? NULL : "a name";
  } else if (strcmp(option, "--output") == 0) {
    o->output = value;
    return *value ? NULL : "the name of a file";
  } else {
    return "an option that --help lists";
  }
  return NULL;
}

int gxysim_parse(int argc, char** argv, int speaks, gxysim_options* o) {
  for (int i = 1; i < argc; i++) {
    const int version = strcmp(argv[i], "--version") == 0;
    if (!version && strcmp(argv[i], "--help") != 0 && strcmp(argv[i], "-h") != 0) continue;
    if (speaks) fputs(version ? "gxysim " GALAXY_VERSION "\n" : help, stdout);
    return 0;
  }
  const char* simulation = argc > 1 ? argv[1] : "";
  const int particles = strcmp(simulation, "particles") == 0;
  if (!particles && strcmp(simulation, "heat") != 0 && strcmp(simulation, "blobs") != 0) {
    if (speaks)
      fprintf(stderr, "gxysim: error: expected heat, blobs or particles, found '%s'; see --help\n",
              simulation);
    return 2;
  }
  *o = (gxysim_options){simulation, simulation, NULL, {64, 64, 64}, {0, 0, 0}, 100, 1, 0, 10, 0};
  if (particles) o->size[0] = 10000;
  for (int i = 2; i < argc; i += 2) {
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    const char* expected = take(argv[i], value, o);
    if (!expected) continue;
    if (speaks) fprintf(stderr, "gxysim: error: %s: expected %s, found '%s'\n", argv[i], expected, value);
    return 2;
  }
  return -1;
}
