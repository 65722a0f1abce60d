/* The paper's swarm of 20 robots, written by hand for AVX-512: a yardstick for the speed of one core.

   It follows docs/model.md 1 to 4 with the paper's values, but it keeps no ids: an inbox counts every message
   (decision.inbox = "every-message"). It has its own generator, and its positions have 16 bits. So its runs differ from
   feasibee's, but their decisions have the same distribution (tests/test_benchmarks.py). It simulates one swarm at a
   time, as feasibee does; it has no outcome but the decision and its step.

   cc -O3 -march=native -o by_hand benchmarks/by_hand.c -lm
   echo "100 1000 1" | ./by_hand

   Each line of the input has tasks (at most 112), runs and a seed. Each line of the output has the CPU time in ns per
   robot-step, the runs that decided feasible and infeasible, and the quartiles of their decision steps. */

#include <immintrin.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#if !(defined __AVX512F__ && defined __AVX512BW__ && defined __AVX512DQ__ && defined __AVX512VL__ && \
      defined __AVX512VBMI2__ && defined __AVX512BITALG__)
#error "needs AVX-512 F, BW, DQ, VL, VBMI2 and BITALG"
#endif

enum { ROBOTS = 20, STEPS = 1000, MOST_TASKS = 112, GRID = 16, CELLS = GRID * GRID, POOL = 1024, UNDECIDED = -1 };
#define UNIT (65536.0f / 20) /* a position has 16 bits, and the arena 20 units */
#define LIMIT 42949672u      /* the square of a range of 2 units */
#define MEAN_RUN 10.0f
#define EXPLORATION 10.0f
#define GAIN 10.0f
#define INLINE static inline __attribute__((always_inline))

/* A place or a velocity is a lane of 32 bits, with x in the lower half and y in the upper. Robots 0 to 15 stand in one
   vector ("a") and 16 to 19 in another ("b"). Timers and numbers of tasks have 16 bits, all robots in one vector. */

typedef struct {
    __m512i words[4];
} Generator;

typedef struct { /* draws of the future, computed together; a robot takes the next */
    uint32_t velocity[POOL + 32];
    uint16_t walk[POOL + 32];
    uint16_t exploration[POOL + 32];
    float exponential[POOL + 32];
} Pools;

typedef struct {
    int decision, step; /* 1 feasible, 0 infeasible */
} Outcome;

static Pools pools __attribute__((aligned(64)));
static int headings_taken, explorations_taken, exponentials_taken;
static uint32_t lists[CELLS * MOST_TASKS] __attribute__((aligned(64))); /* per cell, the tasks near it */

/* xoshiro128+ in 16 lanes. */
INLINE __m512i next(Generator *generator) {
    __m512i *s = generator->words, result = _mm512_add_epi32(s[0], s[3]), t = _mm512_slli_epi32(s[1], 9);
    s[2] = _mm512_xor_si512(s[2], s[0]);
    s[3] = _mm512_xor_si512(s[3], s[1]);
    s[1] = _mm512_xor_si512(s[1], s[2]);
    s[0] = _mm512_xor_si512(s[0], s[3]);
    s[2] = _mm512_xor_si512(s[2], t);
    s[3] = _mm512_rol_epi32(s[3], 11);
    return result;
}

static void seed(Generator *generator, uint64_t state) {
    uint32_t words[64];
    for (int i = 0; i < 64; i++) { /* splitmix64 */
        uint64_t z = (state += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        words[i] = (uint32_t)(z >> 32);
    }
    for (int i = 0; i < 4; i++) generator->words[i] = _mm512_loadu_si512(words + 16 * i);
}

INLINE __m512 polynomial(__m512 x, const float *coefficients, int terms) {
    __m512 sum = _mm512_set1_ps(coefficients[terms - 1]);
    for (int i = terms - 2; i >= 0; i--) sum = _mm512_fmadd_ps(sum, x, _mm512_set1_ps(coefficients[i]));
    return sum;
}

/* Exponential variates of mean 1: the negative logarithm of a uniform number in (0, 1]. */
INLINE __m512 exponential(Generator *generator) {
    static const float series[] = {0.0f,         1.0f,        -0.5f,        0.33333333f,
                                   -0.25f,       0.2f,        -0.16666667f, 0.14285715f,
                                   -0.125f,      0.11111111f, -0.1f,        0.09090909f};
    const __m512 one = _mm512_set1_ps(1.0f), root = _mm512_set1_ps(1.41421356f);
    __m512 u = _mm512_cvtepu32_ps(_mm512_add_epi32(_mm512_srli_epi32(next(generator), 8), _mm512_set1_epi32(1)));
    __m512 mantissa = _mm512_getmant_ps(u, _MM_MANT_NORM_1_2, _MM_MANT_SIGN_zero);
    __m512 power = _mm512_sub_ps(_mm512_getexp_ps(u), _mm512_set1_ps(24.0f));
    __mmask16 high = _mm512_cmp_ps_mask(mantissa, root, _CMP_GT_OQ);
    mantissa = _mm512_mask_mul_ps(mantissa, high, mantissa, _mm512_set1_ps(0.5f));
    power = _mm512_mask_add_ps(power, high, power, one);
    __m512 log = polynomial(_mm512_sub_ps(mantissa, one), series, 12);
    return _mm512_sub_ps(_mm512_setzero_ps(), _mm512_fmadd_ps(power, _mm512_set1_ps(0.69314718f), log));
}

/* A duration as a number of steps: rounded up, at least 1. */
INLINE __m512i steps_of(__m512 duration) {
    __m512i steps = _mm512_cvt_roundps_epi32(duration, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
    return _mm512_max_epi32(steps, _mm512_set1_epi32(1));
}

/* The step of a robot in x and y, with a heading that is uniform on the circle. */
INLINE __m512i velocities(Generator *generator) {
    static const float cosine[] = {1.0f, -0.5f, 4.1666667e-2f, -1.3888889e-3f, 2.4801587e-5f, -2.7557319e-7f};
    static const float sine[] = {1.0f, -0.16666667f, 8.3333333e-3f, -1.9841270e-4f, 2.7557319e-6f, -2.5052108e-8f};
    __m512i word = next(generator);
    /* The upper bits are an angle from -pi/2 to pi/2; bit 0 says whether the robot goes the opposite way. */
    __m512 angle = _mm512_mul_ps(_mm512_cvtepi32_ps(word), _mm512_set1_ps(1.57079633f / 2147483648.0f));
    __m512 square = _mm512_mul_ps(angle, angle);
    __m512 length = _mm512_mask_sub_ps(_mm512_set1_ps(UNIT), _mm512_test_epi32_mask(word, _mm512_set1_epi32(1)),
                                       _mm512_setzero_ps(), _mm512_set1_ps(UNIT));
    __m512i x = _mm512_cvtps_epi32(_mm512_mul_ps(length, polynomial(square, cosine, 6)));
    __m512i y = _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_mul_ps(length, angle), polynomial(square, sine, 6)));
    return _mm512_mask_blend_epi16(0xAAAAAAAA, x, _mm512_slli_epi32(y, 16));
}

INLINE __m256i durations(Generator *generator, float mean) {
    return _mm512_cvtepi32_epi16(steps_of(_mm512_mul_ps(exponential(generator), _mm512_set1_ps(mean))));
}

static void fill_headings(Generator *generator) {
    headings_taken = 0;
    for (int i = 0; i < POOL + 32; i += 16) {
        _mm512_storeu_si512(pools.velocity + i, velocities(generator));
        _mm256_storeu_si256((__m256i *)(pools.walk + i), durations(generator, MEAN_RUN));
    }
}

static void fill_explorations(Generator *generator) {
    explorations_taken = 0;
    for (int i = 0; i < POOL + 32; i += 16)
        _mm256_storeu_si256((__m256i *)(pools.exploration + i), durations(generator, EXPLORATION));
}

static void fill_exponentials(Generator *generator) {
    exponentials_taken = 0;
    for (int i = 0; i < POOL + 32; i += 16) _mm512_storeu_ps(pools.exponential + i, exponential(generator));
}

/* List the tasks of each cell, in at most that many vectors; return how many vectors the longest list takes.

   What is left of a list holds the place that is farthest from the cell. */
static int fill_lists(const uint32_t *tasks, int count, int vectors) {
    const int width = 65536 / GRID;
    int longest = 0;
    for (int cell = 0; cell < CELLS; cell++) {
        uint32_t *list = lists + cell * 16 * vectors;
        uint32_t x = cell % GRID * width + width / 2, y = cell / GRID * width + width / 2;
        __m512i middle = _mm512_set1_epi32((int)(x | y << 16));
        int length = 0;
        for (int i = 0; i < vectors; i++)
            _mm512_store_si512(list + 16 * i, _mm512_xor_si512(middle, _mm512_set1_epi32((int)0x80008000u)));
        for (int i = 0; i < count; i += 16) {
            __m512i task = _mm512_loadu_si512(tasks + i);
            __m512i apart = _mm512_abs_epi16(_mm512_sub_epi16(task, middle));
            apart = _mm512_subs_epu16(apart, _mm512_set1_epi16((short)(width / 2)));
            __mmask16 near = _mm512_cmple_epu32_mask(_mm512_madd_epi16(apart, apart), _mm512_set1_epi32(LIMIT));
            near &= (__mmask16)_bzhi_u32(0xFFFF, (unsigned)(count - i));
            int more = __builtin_popcount(near);
            if (length + more <= 16 * vectors) _mm512_mask_compressstoreu_epi32(list + length, near, task);
            length += more;
        }
        longest = length > longest ? length : longest;
    }
    return (longest + 15) / 16;
}

INLINE __mmask16 in_range(__m512i a, __m512i b) {
    __m512i apart = _mm512_sub_epi16(a, b);
    return _mm512_cmple_epu32_mask(_mm512_madd_epi16(apart, apart), _mm512_set1_epi32(LIMIT));
}

/* The sum of the four quarters of a vector, in each quarter. */
INLINE __m512i sum_quarters(__m512i v) {
    v = _mm512_add_epi32(v, _mm512_shuffle_i64x2(v, v, 0x4E));
    return _mm512_add_epi32(v, _mm512_shuffle_i64x2(v, v, 0xB1));
}

/* What is added to a robot's sum for each robot in its sight: 1, and a vote in the upper half. */
INLINE __m512i messages(uint32_t disseminating, uint32_t feasible) {
    __m512i says = _mm512_set1_epi32(1);
    says = _mm512_mask_mov_epi32(says, (__mmask16)(disseminating & feasible), _mm512_set1_epi32(1 + 65536));
    return _mm512_mask_mov_epi32(says, (__mmask16)(disseminating & ~feasible), _mm512_set1_epi32(1 - 65536));
}

/* Whether the majority of the inbox and the own opinion is feasible; a tie keeps the own opinion. */
INLINE __mmask16 majority(__m512i sums, uint32_t feasible) {
    __m512i least = _mm512_set1_epi32(2 * 65536);
    least = _mm512_mask_mov_epi32(least, (__mmask16)feasible, _mm512_set1_epi32(-65536));
    return _mm512_cmpge_epi32_mask(sums, least);
}

/* The durations of dissemination: exponential variates times the quality of each robot's opinion. */
INLINE __m512i durations_of(__m512i sums, __m256i tasks_seen, uint32_t feasible, __m512 variates) {
    __m512 robots = _mm512_cvtepi32_ps(_mm512_and_si512(sums, _mm512_set1_epi32(0xFFFF)));
    __m512 tasks = _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(tasks_seen));
    __m512 seen = _mm512_add_ps(robots, tasks);
    __mmask16 none = _mm512_cmp_ps_mask(seen, _mm512_setzero_ps(), _CMP_EQ_OQ);
    __m512 share = _mm512_mul_ps(_mm512_mask_mov_ps(tasks, (__mmask16)feasible, robots), _mm512_rcp14_ps(seen));
    share = _mm512_mask_mov_ps(share, none, _mm512_set1_ps(0.5f));
    return steps_of(_mm512_mul_ps(_mm512_mul_ps(variates, _mm512_set1_ps(GAIN)), share));
}

/* Give robots a new heading, and the number of steps until the next. */
INLINE void turn(uint32_t turning, __m512i *velocity_a, __m128i *velocity_b, __m512i *walk_left) {
    const uint32_t *velocity = pools.velocity + headings_taken;
    int first = __builtin_popcount(turning & 0xFFFF);
    *velocity_a = _mm512_mask_expandloadu_epi32(*velocity_a, (__mmask16)turning, velocity);
    *velocity_b = _mm_mask_expandloadu_epi32(*velocity_b, (__mmask8)(turning >> 16), velocity + first);
    *walk_left = _mm512_mask_expandloadu_epi16(*walk_left, turning, pools.walk + headings_taken);
    headings_taken += __builtin_popcount(turning);
}

/* Return the timers with those of robots that begin to disseminate. */
INLINE __m512i disseminate(uint32_t rated, uint32_t feasible, __m512i sums_a, __m512i sums_b, __m512i tasks_seen,
                           __m512i phase_left) {
    const float *variates = pools.exponential + exponentials_taken;
    int first = __builtin_popcount(rated & 0xFFFF);
    __m512 variates_a = _mm512_maskz_expandloadu_ps((__mmask16)rated, variates);
    __m512 variates_b = _mm512_maskz_expandloadu_ps((__mmask16)(rated >> 16), variates + first);
    __m512i a = durations_of(sums_a, _mm512_castsi512_si256(tasks_seen), feasible, variates_a);
    __m512i b = durations_of(sums_b, _mm512_extracti64x4_epi64(tasks_seen, 1), feasible >> 16, variates_b);
    exponentials_taken += __builtin_popcount(rated);
    __m512i both = _mm512_inserti64x4(_mm512_castsi256_si512(_mm512_cvtepi32_epi16(a)), _mm512_cvtepi32_epi16(b), 1);
    return _mm512_mask_mov_epi16(phase_left, rated, both);
}

/* Simulate all steps of one run. `vectors` is the number of vectors in a list of tasks. */
INLINE Outcome play(Generator *generator, int vectors) {
    const __m512i one = _mm512_set1_epi16(1);
    const __mmask32 swarm = (1u << ROBOTS) - 1;
    uint32_t place[32] __attribute__((aligned(64)));
    int32_t says[32] __attribute__((aligned(64)));
    uint16_t near_tasks[32] __attribute__((aligned(64))) = {0};
    __m512i place_a = next(generator), velocity_a = place_a, zero = _mm512_setzero_si512();
    __m128i place_b = _mm512_castsi512_si128(next(generator)), velocity_b = place_b;
    __m512i sums_a = zero, sums_b = zero, tasks_seen = zero, walk_left = one, phase_left = zero;
    uint32_t feasible = swarm & (uint32_t)_mm512_movepi16_mask(next(generator)), disseminating = 0;
    Outcome outcome = {UNDECIDED, -1};
    phase_left = _mm512_mask_loadu_epi16(_mm512_set1_epi16(-1), swarm, pools.exploration + explorations_taken);
    explorations_taken += ROBOTS;
    turn(swarm, &velocity_a, &velocity_b, &walk_left);
    for (int step = 0;; step++) {
        int holders = __builtin_popcount(feasible);
        if (outcome.decision == UNDECIDED && (10 * holders > 9 * ROBOTS || 10 * (ROBOTS - holders) > 9 * ROBOTS))
            outcome = (Outcome){10 * holders > 9 * ROBOTS, step};
        if (step == STEPS) return outcome;
        if (__builtin_expect(headings_taken > POOL, 0)) fill_headings(generator);
        if (__builtin_expect(explorations_taken > POOL, 0)) fill_explorations(generator);
        if (__builtin_expect(exponentials_taken > POOL, 0)) fill_exponentials(generator);

        place_a = _mm512_add_epi16(place_a, velocity_a);
        place_b = _mm_add_epi16(place_b, velocity_b);
        _mm512_store_si512(place, place_a);
        _mm_store_si128((__m128i *)(place + 16), place_b);

        /* Each robot is seen and heard by those in its range, itself for now included. */
        __m512i says_a = messages(disseminating, feasible), says_b = messages(disseminating >> 16, feasible >> 16);
        _mm512_store_si512(says, says_a);
        _mm_store_si128((__m128i *)(says + 16), _mm512_castsi512_si128(says_b));
        asm volatile("" ::: "memory"); /* read them from there: broadcasts of registers take longer */
        __m512i four_b = _mm512_broadcast_i32x4(place_b);
        sums_a = _mm512_sub_epi32(sums_a, says_a);
        sums_b = _mm512_mask_sub_epi32(sums_b, 15, sums_b, says_b);
#define SEE_BY_B(order) \
    sums_b = _mm512_mask_add_epi32(sums_b, in_range(four_b, _mm512_shuffle_epi32(place_a, order)), sums_b, \
                                   _mm512_shuffle_epi32(says_a, order))
        SEE_BY_B(0x00);
        SEE_BY_B(0x55);
        SEE_BY_B(0xAA);
        SEE_BY_B(0xFF);
        const __m512i quarter = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
        sums_b = _mm512_mask_add_epi32(sums_b, in_range(four_b, _mm512_permutexvar_epi32(quarter, four_b)), sums_b,
                                       _mm512_permutexvar_epi32(quarter, says_b));
#pragma GCC unroll 20
        for (int i = 0; i < ROBOTS; i++) {
            __m512i here = _mm512_set1_epi32((int)place[i]);
            sums_a = _mm512_mask_add_epi32(sums_a, in_range(place_a, here), sums_a, _mm512_set1_epi32(says[i]));
            const uint32_t *list = lists + 16 * vectors * _pext_u32(place[i], 0xF000F000u);
            if (vectors == 1) {
                near_tasks[i] = in_range(_mm512_load_si512(list), here);
            } else {
                int count = 0;
                for (int k = 0; k < vectors; k++)
                    count += __builtin_popcount(in_range(_mm512_load_si512(list + 16 * k), here));
                near_tasks[i] = (uint16_t)count;
            }
        }
        __m512i seen = _mm512_load_si512(near_tasks);
        tasks_seen = _mm512_add_epi16(tasks_seen, vectors == 1 ? _mm512_popcnt_epi16(seen) : seen);

        walk_left = _mm512_sub_epi16(walk_left, one);
        turn(swarm & _mm512_testn_epi16_mask(walk_left, walk_left), &velocity_a, &velocity_b, &walk_left);

        phase_left = _mm512_sub_epi16(phase_left, one);
        uint32_t ending = swarm & _mm512_testn_epi16_mask(phase_left, phase_left);
        uint32_t rated = ending & ~disseminating, deciding = ending & disseminating;
        __m512i all_b = sum_quarters(sums_b);
        /* Robots whose exploration ends begin to disseminate. */
        phase_left = disseminate(rated, feasible, sums_a, all_b, tasks_seen, phase_left);
        /* Robots whose dissemination ends decide, and explore again. */
        uint32_t decided = majority(sums_a, feasible) | (uint32_t)majority(all_b, feasible >> 16) << 16;
        feasible = (feasible & ~deciding) | (decided & deciding);
        sums_a = _mm512_maskz_mov_epi32((__mmask16)~deciding, sums_a);
        sums_b = _mm512_maskz_mov_epi32((__mmask16)~((deciding >> 16 & 15) * 0x1111), sums_b);
        tasks_seen = _mm512_maskz_mov_epi16(~deciding, tasks_seen);
        phase_left = _mm512_mask_expandloadu_epi16(phase_left, deciding, pools.exploration + explorations_taken);
        explorations_taken += __builtin_popcount(deciding);
        disseminating ^= ending;
    }
}

/* Draw a world and simulate it; choose the length of the lists of tasks. */
static Outcome simulate(Generator *generator, int tasks) {
    uint32_t places[MOST_TASKS];
    for (int i = 0; i < MOST_TASKS; i += 16) _mm512_storeu_si512(places + i, next(generator));
    if (fill_lists(places, tasks, 1) <= 1) return play(generator, 1);
    if (fill_lists(places, tasks, 2) <= 2) return play(generator, 2);
    fill_lists(places, tasks, MOST_TASKS / 16);
    return play(generator, MOST_TASKS / 16);
}

static int by_size(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

int main(void) {
    int tasks, runs;
    unsigned long long number;
    while (scanf("%d %d %llu", &tasks, &runs, &number) == 3 && 0 < tasks && tasks <= MOST_TASKS && runs > 0) {
        int counts[2] = {0, 0}, *steps = malloc(sizeof(int) * (size_t)runs), decided = 0;
        Generator generator;
        seed(&generator, number);
        clock_t start = clock();
        fill_headings(&generator);
        fill_explorations(&generator);
        fill_exponentials(&generator);
        for (int run = 0; run < runs; run++) {
            Outcome outcome = simulate(&generator, tasks);
            if (outcome.decision == UNDECIDED) continue;
            counts[outcome.decision]++;
            steps[decided++] = outcome.step;
        }
        double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
        qsort(steps, (size_t)decided, sizeof(int), by_size);
        printf("%.4f %d %d", seconds * 1e9 / ((double)runs * STEPS * ROBOTS), counts[1], counts[0]);
        for (int quarter = 1; quarter <= 3; quarter++)
            printf(" %d", decided ? steps[(decided - 1) * quarter / 4] : -1);
        printf("\n");
        fflush(stdout);
        free(steps);
    }
    return 0;
}
