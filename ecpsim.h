/* ecpsim.h - rigid bodies whose contacts are patches, one equation system a step

   A single C file, no dependency but sqrt, memcpy and memset. In ONE unit of your program:

       #define ECPSIM_IMPLEMENTATION
       #include "ecpsim.h"

   and plain #include "ecpsim.h" elsewhere. Licence: MIT or public domain, see the end of the file.

   CONTENTS (search for the marker)
       >>manual       this text                >>linear       dense linear algebra
       >>config       real type, linkage       >>shapes       primitives
       >>linear-api   dense linear algebra     >>world        memory, bodies
       >>shapes-api   primitives               >>motion       a body within a step
       >>world-api    memory, bodies, loads    >>equations    residual and Jacobian of a patch
       >>step-api     options, step, contacts  >>elimination  one Newton step of an island
       >>advance-api  to a time, in tolerance    >>order        in which bodies are eliminated
       >>check-api    the paper's equations      >>front        factor and solve
       >>mcp-api      general solver             >>island       unknowns and residual of all its bodies
                                               >>newton       the globalisation
                                               >>mcp          the general solver
                                               >>distance     between two primitives
                                               >>start        values of a patch without a history
                                                 >>spots        the same, from several points
                                               >>broad        what can meet within the step
                                               >>step         predict, solve, verify, commit
                                                 >>memory       where every block of it lies
                                                 >>patches      which pairs are in the equations
                                                 >>sleep        islands that repeat their last step
                                                 >>solve        one island, fallback by fallback
                                                 >>working-set  patches join as they are needed
                                               >>contacts     what a step found, for the caller
                                               >>advance      extrapolation, events
                                               >>dump         a step as C source
                                               >>printed      the paper's equations, as a check

   >>manual

   WHAT IT SOLVES
   Bodies are unions of convex primitives. Wherever two primitives touch there is a patch: a point,
   a line or a surface. Following Xie & Chakraborty, "Rigid Body Dynamic Simulation with Multiple
   Convex Contact Patches" (DETC2018-85429), each patch acts through one equivalent contact point
   (ECP), and a time step is one mixed nonlinear complementarity problem for the velocities, the
   ECPs and the impulses (normal, friction and torsion) at the END of the step. Contact detection
   is part of the problem, so bodies end a step without penetration, and a body that stands on
   three legs or on a face needs no hand-picked contact points. ecp_step() solves it to rounding,
   checks the answer by support functions, and commits it; or it returns a status and has changed
   nothing.

   A COMPLETE PROGRAM (examples/minimal.c)

       #define ECPSIM_IMPLEMENTATION
       #include "ecpsim.h"
       #include <stdio.h>
       #include <stdlib.h>

       int main(void)
       {
           const ecp_real up[3] = {0, 0, 1}, half[3] = {0.2, 0.1, 0.05}; // m
           const ecp_real inertia[9] = {0.0042, 0, 0, 0, 0.0142, 0, 0, 0, 0.0167};
           ecp_world_desc desc = ecp_world_desc_default();
           ecp_body_desc body = ecp_body_desc_default();
           ecp_world *world;
           ecp_shape shape;
           ecp_real x[3];
           size_t bytes = ecp_world_memsize(&desc);
           if (ecp_world_init(&world, &desc, malloc(bytes), bytes) != ECP_OK) return 1;

           body.kind = ECP_STATIC; // body 0: the ground, z <= 0
           ecp_body_add(world, &body, NULL);
           ecp_shape_half_space(&shape, up, 0);
           ecp_body_add_shape(world, 0, &shape, NULL, NULL, NULL, NULL);

           body.kind = ECP_DYNAMIC; // body 1: a box of 1 kg, thrown
           for (int i = 0; i < 9; i++) body.inertia[i] = inertia[i];
           body.position[2] = 0.5;
           body.velocity[0] = 1;
           ecp_body_add(world, &body, NULL);
           ecp_shape_box(&shape, half);
           ecp_body_add_shape(world, 1, &shape, NULL, NULL, NULL, NULL);

           for (int k = 0; k < 100; k++) {
               ecp_status status = ecp_step(world, 0.01, NULL, NULL);
               if (status != ECP_OK) return puts(ecp_status_string(status)), 1;
           }
           ecp_body_get_state(world, 1, x, NULL, NULL, NULL);
           printf("minimal: the box rests at (%.6f, %.6f, %.6f)\n", x[0], x[1], x[2]);
           free(world);
           return 0;
       }

   A BODY OF SEVERAL PRIMITIVES (examples/hammer.c)
   The frame of a body has its origin at the centre of mass. Draw the parts in any frame, add up their
   masses there, and take the centre off where they are:

       ecp_mass total, part;
       memset(&total, 0, sizeof total);
       for (i = 0; i < parts; i++) {
           ecp_shape_mass(&shape[i], density[i], &part); // kg/m^3
           ecp_mass_add(&total, &part, place[i], turn[i]); // turn: (w, x, y, z)
       }
       // body.mass = total.mass, body.inertia = total.inertia; then for each part, with
       // position = place[i] - total.centre:
       ecp_body_add_shape(world, index, &shape[i], position, turn[i], &material[i], NULL);

   OPTIONS
   ecp_step() takes ecp_options or NULL. `rule` chooses among the many solutions that a body on two
   or more patches has: ECP_CENTRED (the default) is a function of the state alone where
   ecp_report.centred says that it was reached (of the solutions that hang together with the one found;
   docs/model.md), ECP_NEAREST stays near the last step's, or near ecp_guess_ecp(). `tolerance` bounds
   the residual in scaled units, `max_iterations` and `fallbacks` the work. Compile-time macros, to be
   defined alike before every inclusion:

       ECPSIM_FLOAT     single precision everywhere (own symbols: mixing does not link)
       ECPSIM_STATIC    public functions are static; for one unit that keeps them to itself
       ECPSIM_SQRT(x)   instead of sqrt of <math.h>; correctly rounded, or bits differ
       ECPSIM_MEMCPY, ECPSIM_MEMSET   instead of <string.h>, both or none
       ECPSIM_ASSERT(x) instead of assert; guards against the library's own errors only

   A TIME WITHIN A TOLERANCE
   A step is first order: ten times the work for a digit. ecp_advance() reaches a time within a
   tolerance and chooses its steps and their order by itself, up to twelve; it finds landings, stops
   and other changes of the contacts where they happen. Where these are too dense to be told apart
   it goes on without the tolerance: report.forced says how often, report.error how far off. The
   world needs memory for it (examples/advance.c, docs/advance.md; a program that does not name it
   does not have it):

       desc.advance_order = 8;
       ...
       advance = ecp_advance_options_default();
       advance.tolerance = 1e-9;
       status = ecp_advance(world, 5, &advance, &report); // 5 s

   WHAT A PROGRAM DOES NOT NEED
   Compile with -ffunction-sections and link with -Wl,--gc-sections: what a program does not name is
   not linked, and what a scene does not contain (friction, torsion, pairs) has no unknowns. What only
   the program can know that it never meets, it can leave out. Bytes: of code on a Cortex-M4F (gcc 12
   -Os, ECPSIM_FLOAT, ECPSIM_STATIC) for a table on three legs, as printed by `make size`, of 66,236.

       ECPSIM_NO_PAIRS     28,224  primitives meet half-spaces only; others pass through each other, as
                                   with ecp_shape_set_filter(). Also needs half of the work memory
       ECPSIM_NO_FRICTION   5,360  contacts are smooth, whatever the materials say
       ECPSIM_NO_SLEEP      1,600  options.sleep = 1 is ECP_BAD_OPTION
       ECPSIM_NO_CENTRING   2,956  the rule is ECP_NEAREST, and ECP_CENTRED is ECP_BAD_OPTION
       ECPSIM_FALLBACKS    10,956  the ECP_FALLBACK_... that there are, or-ed; all, where nothing is
                                   said. Options that ask for others are ECP_BAD_OPTION. The bytes
                                   are what 0, none, saves; ECP_FALLBACK_GEOMETRIC alone saves 6,540,
                                   all but ECP_FALLBACK_SUBSTEPS 3,036 and the memory of a second state

   MEMORY
   ecp_world_memsize(desc) bytes, aligned to 8, hold a world with all its work memory; nothing is
   allocated. The stack stays small and bounded. A world contains no address of itself: copying the
   block copies the world, copying it back restores it. Different worlds may run on different threads.

   BODIES THAT GO
   ecp_body_remove() takes a body and its shapes out between steps. Indices never move: those of the
   others stay, the free ones go to what is added next, the lowest first. A loop over all bodies runs
   to ecp_world_body_count() and leaves out those of which ecp_body_get_state() says ECP_BAD_INDEX.

   WHAT MAY TOUCH WHAT
   Primitives of one body never touch each other. ecp_shape_set_filter() gives a primitive 32 bits of
   what it is and 32 bits of what it meets; pairs that do not meet are not looked at.
   ecp_shape_set_material() changes its friction. Both may be called between any two steps.

   SLEEP
   With options.sleep = 1 an island, a group of bodies that touch, is left out of the problem once a
   step has left it exactly as it was. It wakes when something that matters to it changes: a load on a
   body of it that is not zero, or a state that is not the one it has (ecp_body_set_state with NULLs
   only wakes it and does nothing else), of what it lies on too; a shape, a filter or a material of these; a body
   that is taken away, or whose motion may reach it within the step; gravity, h, or an option; ecp_advance() wakes all.
   A step that is left out would have given the same bits, so sleep changes no bit of any body or contact at
   any time: it only saves time. (So an island that takes iterations of a bounded number,
   options.max_total_iterations, does not sleep: the others would find more of them left.) Contacts of
   bodies that sleep are there as always; ecp_report.asleep counts the bodies. Only what the library
   cannot see must not change under a body that sleeps: the numbers behind the pointers of a shape.

   A STEP AS A TEST
   ecp_dump() writes the step to come as a C function that makes the same world, bit for bit, and does
   the step: for a test, or for a report of a step that is not solved. With these fields of
   ecp_options every ecp_step that ends in ECP_NOT_SOLVED writes itself (ecp_dump is 7 kB of code, and it
   names all shapes):

       static void put(void *file, const char *text) { fputs(text, (FILE *)file); }
       ...
       options.dump = ecp_dump;
       options.dump_write = put;
       options.dump_user = fopen("step.c", "w");

   ERRORS
   Every call that can fail returns ecp_status: zero is success, ecp_status_string() a sentence.
   Bad input (NaN, negative sizes, a tetrahedron that is open, ...) always gets its own status and
   changes nothing. Of every call: NULL where nothing says that it may be is ECP_BAD_POINTER, NaN or an infinite
   number ECP_NOT_FINITE, an index where there is nothing ECP_BAD_INDEX, a quaternion without a length
   ECP_BAD_ROTATION; what adds to the world, takes from it or steps it within a callback of ecp_advance() is
   ECP_BAD_OPTION. The declarations say what else there is. (Calls that return a number give 0 for NULL.)
   A step fails with ECP_NOT_SOLVED, with ECP_CAPACITY where the description was too small, or with ECP_NOT_FINITE
   where its numbers grow out of range; ecp_report then says at which body or shapes, with which value, against
   which limit.

   UNITS AND FRAMES
   SI units or any consistent ones. Right-handed world frame; no axis is special. Body frames have
   their origin at the centre of mass. Quaternions are (w, x, y, z) and turn body axes into world
   axes; matrices are row major. Velocities and angular velocities are in world axes. Contact
   normals point from B to A; impulses are those on A.

   DETERMINISM
   A step uses + - * / and sqrt in a fixed order, so a world is a function of its calls, bit for
   bit, on one compiler and machine. Compile with -ffp-contract=off, without -ffast-math, for bits
   that do not depend on the compiler; ecp_arithmetic() tells whether it has worked. `make hashes`
   compares seven scenes in double and in float, between gcc and clang, their optimisation levels,
   x86-64, 32-bit x86 with SSE2, ARM under qemu and WebAssembly.

   LIMITS
   A step is first order in h, like every time-stepping scheme of this kind; impacts do not bounce.
   A solution in which bodies go straight through each other in a step is not taken; one that turns
   far in the step, or that cuts a corner, may end on the other side. A cone's tip is a disc of 1e-5
   of its size. With several contacts the impulses are one solution of many. Where a body turns far
   within a step its gyroscopic moment is taken at the end of the step, not at the beginning.

   REAL TIME
   options.max_total_iterations bounds the Newton iterations of a step, all attempts together; a step
   that it ends is ECP_NOT_SOLVED, and the world untouched. A solution whose contacts win energy is given
   up for shorter steps only if the bound leaves more iterations than it has taken, and taken after all
   if the rest finds none that is better: ecp_report.work above 0.01, or midway above 0.02, says so.
   docs/embedding.md: memory, stack, time, what to do where a bound ends a step, porting.

   EQUATIONS
   docs/model.md derives them, docs/numerics.md the solver. Comments name the paper's LaTeX labels. */

/* >>config ================================================================================ */

#ifndef ECPSIM_H
#define ECPSIM_H

#include <stddef.h>
#include <stdint.h> /* like <stddef.h> it comes with the compiler, without a C library */

#ifdef __cplusplus
extern "C" {
#endif

/* The real type of the whole library. Define ECPSIM_FLOAT before every inclusion to work in
   single precision; then no double is used anywhere. */
#ifdef ECPSIM_FLOAT
typedef float ecp_real;
#else
typedef double ecp_real;
#endif

/* Linkage of the public functions: external by default, file-local with ECPSIM_STATIC. */
#ifndef ECP_DEF
#ifdef ECPSIM_STATIC
#if defined(__GNUC__)
#define ECP_DEF static __attribute__((unused))
#else
#define ECP_DEF static
#endif
#else
#define ECP_DEF extern
#endif
#endif

/* The single-precision library has its own symbols, so a program whose units do not agree on the
   real type does not link. */
#ifdef ECPSIM_FLOAT
#define ecp_status_string ecp_f32_status_string
#define ecp_arithmetic ecp_f32_arithmetic
#define ecp_lu_factor ecp_f32_lu_factor
#define ecp_lu_solve ecp_f32_lu_solve
#define ecp_chol_factor ecp_f32_chol_factor
#define ecp_chol_solve ecp_f32_chol_solve
#define ecp_qr_factor ecp_f32_qr_factor
#define ecp_qr_apply_qt ecp_f32_qr_apply_qt
#define ecp_qr_apply_q ecp_f32_qr_apply_q
#define ecp_least_squares ecp_f32_least_squares
#define ecp_eliminate ecp_f32_eliminate
#define ecp_quat_to_matrix ecp_f32_quat_to_matrix
#define ecp_quat_multiply ecp_f32_quat_multiply
#define ecp_quat_advance ecp_f32_quat_advance
#define ecp_shape_half_space ecp_f32_shape_half_space
#define ecp_shape_sphere ecp_f32_shape_sphere
#define ecp_shape_ellipsoid ecp_f32_shape_ellipsoid
#define ecp_shape_capsule ecp_f32_shape_capsule
#define ecp_shape_cylinder ecp_f32_shape_cylinder
#define ecp_shape_frustum ecp_f32_shape_frustum
#define ecp_shape_box ecp_f32_shape_box
#define ecp_shape_polytope ecp_f32_shape_polytope
#define ecp_shape_convex ecp_f32_shape_convex
#define ecp_shape_bounds ecp_f32_shape_bounds
#define ecp_shape_mass ecp_f32_shape_mass
#define ecp_mass_add ecp_f32_mass_add
#define ecp_world_desc_default ecp_f32_world_desc_default
#define ecp_world_memsize ecp_f32_world_memsize
#define ecp_world_init ecp_f32_world_init
#define ecp_world_state_size ecp_f32_world_state_size
#define ecp_world_set_gravity ecp_f32_world_set_gravity
#define ecp_world_body_count ecp_f32_world_body_count
#define ecp_world_shape_count ecp_f32_world_shape_count
#define ecp_material_default ecp_f32_material_default
#define ecp_body_desc_default ecp_f32_body_desc_default
#define ecp_body_add ecp_f32_body_add
#define ecp_body_remove ecp_f32_body_remove
#define ecp_body_add_shape ecp_f32_body_add_shape
#define ecp_body_get_state ecp_f32_body_get_state
#define ecp_body_set_state ecp_f32_body_set_state
#define ecp_body_apply_force ecp_f32_body_apply_force
#define ecp_body_apply_torque ecp_f32_body_apply_torque
#define ecp_body_apply_impulse ecp_f32_body_apply_impulse
#define ecp_body_apply_angular_impulse ecp_f32_body_apply_angular_impulse
#define ecp_body_clear_loads ecp_f32_body_clear_loads
#define ecp_shape_get ecp_f32_shape_get
#define ecp_shape_set_filter ecp_f32_shape_set_filter
#define ecp_shape_set_material ecp_f32_shape_set_material
#define ecp_options_default ecp_f32_options_default
#define ecp_step ecp_f32_step
#define ecp_guess_ecp ecp_f32_guess_ecp
#define ecp_contact_count ecp_f32_contact_count
#define ecp_contact_get ecp_f32_contact_get
#define ecp_advance_options_default ecp_f32_advance_options_default
#define ecp_advance ecp_f32_advance
#define ecp_dump ecp_f32_dump
#define ecp_printed_residual ecp_f32_printed_residual
#define ecp_translation_step ecp_f32_translation_step
#define ecp_mcp_memsize ecp_f32_mcp_memsize
#define ecp_mcp_solve ecp_f32_mcp_solve
#endif

/* Every result of a public call. Zero is success; a call that returns anything else has changed
   nothing but its report, the vertex buffer of ecp_shape_polytope and the memory of ecp_mcp_solve (and ecp_dump may
   have written some of its text). ecp_status_string() gives the sentence. */
#define ECP_STATUS_LIST(X)                                                                         \
    X(ECP_OK, 0, "success")                                                                        \
    X(ECP_NOT_SOLVED, -1, "the equations were not solved within the limits; all is as it was")     \
    X(ECP_BAD_POINTER, -2, "a required pointer is NULL")                                           \
    X(ECP_NOT_FINITE, -3, "a number is NaN or infinite")                                           \
    X(ECP_BAD_SIZE, -4,                                                                            \
      "a size, radius or normal is not positive, or its square is beyond numbers")                 \
    X(ECP_EMPTY_POLYTOPE, -5, "the half-spaces of the polytope have no common interior")           \
    X(ECP_UNBOUNDED_POLYTOPE, -6, "the half-spaces of the polytope leave a direction open")        \
    X(ECP_BAD_MASS, -7, "the mass of a dynamic body must be positive, and 1 / mass a number")      \
    X(ECP_BAD_INERTIA, -8, "the inertia is not symmetric positive definite")                       \
    X(ECP_BAD_INERTIA_TRIANGLE, -9,                                                                \
      "the inertia violates the triangle inequality: no solid has it")                             \
    X(ECP_BAD_ROTATION, -10, "the quaternion (w, x, y, z) has no length")                          \
    X(ECP_BAD_STEP, -11, "the time step must be positive")                                         \
    X(ECP_BAD_FRICTION, -12, "the friction coefficient must not be negative")                      \
    X(ECP_BAD_ELLIPSOID, -13, "friction ellipsoid: e_t, e_o must be positive, e_r not negative")   \
    X(ECP_BAD_INDEX, -14, "no body, shape or contact has this index")                              \
    X(ECP_BAD_KIND, -15,                                                                           \
      "not for a body of this kind (a half-space is never dynamic, a load needs a dynamic body)")  \
    X(ECP_BAD_OPTION, -16, "an option or a description field is outside its range")                \
    X(ECP_MEMORY_SMALL, -17, "the memory block is smaller than the memsize function says")         \
    X(ECP_MEMORY_ALIGN, -18, "the memory block is not aligned to 8 bytes")                         \
    X(ECP_CAPACITY, -19, "a capacity of the description or the buffer is used up")                 \
    X(ECP_TOLERANCE, -20, "the tolerance is below what rounding leaves")                           \
    X(ECP_BAD_SUPPORT, -21,                                                                        \
      "a support point is not the farthest of its shape's, or farther away than the radius")

typedef enum ecp_status {
#define ECP_I_ENUM(name, value, text) name = value,
    ECP_STATUS_LIST(ECP_I_ENUM)
#undef ECP_I_ENUM
} ecp_status;

/* The sentence that belongs to a status; never NULL. */
ECP_DEF const char *ecp_status_string(ecp_status status);

/* What keeps a step from giving the same bits as on any other machine, or-ed. */
enum {
    ECP_ARITHMETIC_FORMAT =
        1, /* ecp_real is not binary64 (binary32 with ECPSIM_FLOAT) of IEEE 754 */
    ECP_ARITHMETIC_EXCESS = 2,    /* expressions keep more digits than their type has (x87), or are
                                      reordered (-ffast-math) */
    ECP_ARITHMETIC_ROUNDING = 4,  /* not to the nearest, ties to even; by fesetround() for one */
    ECP_ARITHMETIC_SUBNORMAL = 8, /* the smallest numbers count as zero */
    ECP_ARITHMETIC_CONTRACTED = 16, /* a * b + c is rounded once: compile with -ffp-contract=off */
    ECP_ARITHMETIC_INEXACT = 32,    /* a quotient or a root is not the nearest number */
    ECP_ARITHMETIC_NAN = 64         /* NaN is not told from a number: bad input would get through */
};

/* Tries + - * / and sqrt as this library is compiled, on this thread as it is now: 0 if they do what
   IEEE 754 says, else ECP_ARITHMETIC_... or-ed. It is not called by the library; a program that
   relies on the same bits elsewhere does, once a thread and after what changes the modes of the
   floating-point unit. A sample, not a proof. */
ECP_DEF int ecp_arithmetic(void);

/* >>linear-api ============================================================================ */

/* Dense linear algebra on caller memory: row-major matrices, `ld` reals from row to row. */

/* LU with partial pivoting of the n x n matrix A, in place; piv[n] receives the row exchanges.
   Returns 0, or 1 + the index of the first pivot that is exactly zero. */
ECP_DEF int ecp_lu_factor(int n, ecp_real *A, int ld, int *piv);

/* Solves A x = b with the factors of ecp_lu_factor; b is overwritten by x. */
ECP_DEF void ecp_lu_solve(int n, const ecp_real *A, int ld, const int *piv, ecp_real *b);

/* Cholesky A = L L^T of a symmetric n x n matrix: reads the lower triangle and overwrites it by L.
   Returns 0, or 1 + the index of the first pivot that is not positive. */
ECP_DEF int ecp_chol_factor(int n, ecp_real *A, int ld);

/* Solves A x = b with the factor of ecp_chol_factor; b is overwritten by x. */
ECP_DEF void ecp_chol_solve(int n, const ecp_real *A, int ld, ecp_real *b);

/* Householder QR with column pivoting, A P = Q R, of an m x n matrix in place: R above the
   diagonal, the reflectors below it, their factors in tau[min(m,n)], the column order in piv[n]
   (column k of A P is column piv[k] of A). Stops at the first column whose remaining norm is not
   above tolerance times the first one's, and returns the rank found. */
ECP_DEF int ecp_qr_factor(int m, int n, ecp_real *A, int ld, ecp_real *tau, int *piv,
                          ecp_real tolerance);

/* Overwrites b[m] by Q^T b, and by Q b, for the first `rank` reflectors of ecp_qr_factor. */
ECP_DEF void ecp_qr_apply_qt(int m, int rank, const ecp_real *A, int ld, const ecp_real *tau,
                             ecp_real *b);
ECP_DEF void ecp_qr_apply_q(int m, int rank, const ecp_real *A, int ld, const ecp_real *tau,
                            ecp_real *b);

/* The shortest x[n] of those that minimise |A x - b|, for an m x n matrix of any rank (a complete
   orthogonal decomposition). A and b[m] are overwritten; work holds ECP_LEAST_SQUARES_WORK(m, n)
   reals (as many for any m: what has m rows is worked on in place) and iwork 2 n ints. Returns the
   rank at the given relative tolerance. Entries are finite, and columns have lengths that are (which is
   not checked: of others x means nothing, finite or not). */
#define ECP_LEAST_SQUARES_WORK(m, n) ((n) * (n) + 3 * (n))
ECP_DEF int ecp_least_squares(int m, int n, ecp_real *A, int ld, ecp_real *b, ecp_real *x,
                              ecp_real *work, int *iwork, ecp_real tolerance);

/* Gaussian elimination with complete pivoting inside the leading rows x cols block of an
   all_rows x all_cols matrix, from pivot `first` on; rows from `rows` on and columns from `cols` on
   are updated but never pivoted (they belong to somebody else). A pivot may stand where
   row_tag[i] & mask and col_tag[j] & mask are both not zero. Stops when no such entry exceeds
   `tolerance` in size, and returns the number of pivots so far; what is left of the block could
   not be pivoted. Below each pivot stand the multipliers of its row, as of an LU, with which another
   right-hand side can be eliminated later. row_tag[rows] and col_tag[cols], as well as row_order and
   col_order, which say which row and column of the original stands at each place, are exchanged
   along; row_order may be NULL. */
ECP_DEF int ecp_eliminate(ecp_real *A, int ld, int all_rows, int all_cols, int rows, int cols,
                          int first, int mask, ecp_real tolerance, int *row_tag, int *col_tag,
                          int *row_order, int *col_order);

/* Rotations are unit quaternions (w, x, y, z) that turn body axes into world axes. */

/* R[9], row major, of the unit quaternion q. */
ECP_DEF void ecp_quat_to_matrix(const ecp_real q[4], ecp_real R[9]);

/* out = a b (first b, then a); out may be a or b. */
ECP_DEF void ecp_quat_multiply(const ecp_real a[4], const ecp_real b[4], ecp_real out[4]);

/* The rotation after a time h at the world angular velocity w by equ:kinematic, renormalised:
   exactly the Cayley transform of h w applied to q. out may be q. |h w|^2 must not overflow. */
ECP_DEF void ecp_quat_advance(const ecp_real q[4], const ecp_real w[3], ecp_real h,
                              ecp_real out[4]);

/* >>shapes-api ============================================================================

   A shape is a convex solid {x : f_1(x) <= 0, ..., f_m(x) <= 0} in its own frame (metres). Each
   f_i is a length in metres, and its gradient has unit length where f_i = 0 bounds the solid, so a
   multiplier of f_i is a component of the unit normal, whatever the size of the shape. The f_i are
   finite, and continuously differentiable, inside and outside the solid, because Newton's method
   walks through both. (The sets f_i <= 0 are convex, the f_i need not be; and a gradient whose length is
   not one, but the same within a factor of ten over the surface, costs iterations only.)

     kind         f_i, in this order                                          m   size[]
     half-space   n.x - c                                                     1   n, c
     sphere       (|x|^2 - r^2) / (2 r)                                       1   r
     ellipsoid    (Q - 1) / (2 sqrt(P + max(0, 1 - Q)^2 / a_min^2)),          1   a_1, a_2, a_3
                  Q = sum x_k^2 / a_k^2, P = sum x_k^2 / a_k^4
     capsule      (squared distance to the segment - r^2) / (2 r)             1   r, h
     cylinder     (x^2 + y^2 - r^2) / (2 r), z - h, -z - h                    3   r, h
     frustum      ((x^2 + y^2) / rho - rho) / (2 sqrt(1 + k^2)), z - h,       3   r_bottom, r_top,
                  -z - h, with rho linear in z and k = rho'                       h, sqrt(1 + k^2)
     box          x - a_1, -x - a_1, y - a_2, -y - a_2, z - a_3, -z - a_3     6   a_1, a_2, a_3
     polytope     n_i.x - c_i                                                 m   largest |vertex|

   The second derivatives of the capsule's f jump where its cylinder meets its half balls; all the
   others are twice continuously differentiable. Values are finite as long as the square of |x| over
   the smallest size does not overflow (second derivatives of an ellipsoid: nor the fifth power of the ratio
   of its radii). */

typedef struct ecp_shape ecp_shape;

/* Mass properties. `inertia` is about `centre`, row major, along the axes of the frame in which
   `centre` is given. */
typedef struct ecp_mass {
    ecp_real mass;       /* kg */
    ecp_real centre[3];  /* m */
    ecp_real inertia[9]; /* kg m^2 */
} ecp_mass;

typedef enum ecp_shape_kind {
    ECP_HALF_SPACE,
    ECP_SPHERE,
    ECP_ELLIPSOID,
    ECP_CAPSULE,
    ECP_CYLINDER,
    ECP_FRUSTUM,
    ECP_BOX,
    ECP_POLYTOPE,
    ECP_CONVEX
} ecp_shape_kind;

/* What a kind of shape can do. All vectors are in the shape's frame, and no output may overlap an
   input. A class of one's own goes to ecp_shape_convex(); to keep a step bitwise reproducible on
   every machine its functions should use + - * / and sqrt only. */
typedef struct ecp_shape_class {
    /* Writes f[i] = f_i(x) for i < m and, unless g is NULL, the gradient of f_i to the three reals
       from g[3 i] on. */
    void (*eval)(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g);

    /* Overwrites H (3 x 3, row major, symmetric) with sum_i l[i] Hess f_i(x). This pointer is NULL
       when all f_i are affine. An H that is not exact costs iterations, and one without its larger terms the
       solution. */
    void (*hess)(const ecp_shape *s, const ecp_real x[3], const ecp_real *l, ecp_real H[9]);

    /* Writes a point of the solid that is farthest along the unit vector n, and that to rounding: by it steps are
       checked for penetration, and a face that is found 1e-9 of its size too far in is not solved. Where n is within
       `flat` of the normal of a face, or of a direction normal to an edge or a generator, it is the
       middle of that face, edge or generator. `flat` is the sine of an angle, 0 <= flat < 0.5; zero
       leaves only ties (of a polytope: ties to rounding). */
    void (*support)(const ecp_shape *s, const ecp_real n[3], ecp_real flat, ecp_real x[3]);

    /* Writes the mass properties at a density of 1 kg/m^3. */
    void (*mass)(const ecp_shape *s, ecp_mass *out);
} ecp_shape_class;

/* A shape. The constructors below fill it; treat it as read-only afterwards. It may be copied, and
   shared by any number of bodies. */
struct ecp_shape {
    const ecp_shape_class *cls;
    ecp_shape_kind kind;
    int inequalities;         /* m */
    int vertex_count;         /* polytope only, else 0 */
    ecp_real size[4];         /* see the table above; unused entries are 0 */
    ecp_real centre[3];       /* the centroid (half-space: the boundary point nearest the origin) */
    ecp_real radius;          /* of a ball about `centre` that holds the shape; < 0: unbounded */
    const ecp_real *planes;   /* polytope only: m rows (n_x, n_y, n_z, c), the caller's */
    const ecp_real *vertices; /* polytope only: vertex_count rows (x, y, z), the caller's */
    const void *user;         /* ECP_CONVEX only */
};

/* Constructors.

   Each returns ECP_OK and writes *s, or returns an error and leaves *s as it was:
   ECP_BAD_POINTER for a NULL argument, ECP_NOT_FINITE for a NaN or an infinity, ECP_BAD_SIZE for
   a size that is not positive, or so large or small that its square is no number or nothing. Further
   errors are stated where they can occur. */

/* The half-space {x : normal.x <= offset}. `normal` points out of the solid and need not have unit
   length: normal and offset are divided by |normal|, which leaves the set unchanged. A zero normal
   gives ECP_BAD_SIZE. It has no mass, so it cannot belong to a dynamic body. */
ECP_DEF ecp_status ecp_shape_half_space(ecp_shape *s, const ecp_real normal[3], ecp_real offset);

/* The ball of radius `radius` about the origin. */
ECP_DEF ecp_status ecp_shape_sphere(ecp_shape *s, ecp_real radius);

/* The ellipsoid about the origin with semi-axes radii[k] along the axes of the frame. */
ECP_DEF ecp_status ecp_shape_ellipsoid(ecp_shape *s, const ecp_real radii[3]);

/* All points within `radius` of the segment from (0, 0, -half_length) to (0, 0, half_length).
   half_length may be 0. */
ECP_DEF ecp_status ecp_shape_capsule(ecp_shape *s, ecp_real radius, ecp_real half_length);

/* The cylinder of radius `radius` about the z axis, |z| <= half_height. */
ECP_DEF ecp_status ecp_shape_cylinder(ecp_shape *s, ecp_real radius, ecp_real half_height);

/* The frustum of a cone about the z axis, |z| <= half_height, with radius `bottom_radius` at
   z = -half_height and `top_radius` at z = half_height. One of the radii may be 0: a cone. A tip
   has no gradient, so a radius below 1e-5 (float: 1e-3) of the larger of the other radius and
   half_height is raised to that, though not above the other radius; the solid then contains the one
   asked for. size[] holds the radii in use. */
ECP_DEF ecp_status ecp_shape_frustum(ecp_shape *s, ecp_real bottom_radius, ecp_real top_radius,
                                     ecp_real half_height);

/* The box |x_k| <= half[k]. */
ECP_DEF ecp_status ecp_shape_box(ecp_shape *s, const ecp_real half[3]);

/* The polytope {x : n_i.x <= c_i}, from `count` rows (n_x, n_y, n_z, c) of outward unit normals and
   offsets in metres. Redundant and repeated planes are allowed.

   `vertices` has room for `vertex_capacity` points of 3 reals and receives the vertices; a bounded
   polytope of m facets has at most 2 m - 4 (and a few more if it has a tip so sharp, with four facets
   or more, that their rounding draws it apart). Both buffers stay the caller's, must not overlap, are
   kept by pointer, and must outlive the shape unchanged. On an error the contents of `vertices` are
   undefined.

   Vertices closer together than 1e-10 (float: 4e-5) of the largest distance of a vertex from the
   origin are one vertex, and a polytope thinner than that is empty; so put the origin near the
   polytope. The cost is O(count^4): this is for tens of planes, not for thousands.

   Errors: ECP_BAD_SIZE for a count or capacity below 1, for a normal whose length differs from 1 by
   more than 1e-6, and for planes so nearly parallel that rounding decides what the faces are;
   ECP_UNBOUNDED_POLYTOPE if a ray stays inside all planes that are moved to pass through its
   origin, or leaves none by more than 1e-8 (float: 4e-4) of its length, as in a needle that tapers no
   more (looked at first, so also for some empty sets); ECP_EMPTY_POLYTOPE if there is no inner
   point; ECP_CAPACITY if there are more vertices than fit. */
ECP_DEF ecp_status ecp_shape_polytope(ecp_shape *s, const ecp_real *planes, int count,
                                      ecp_real *vertices, int vertex_capacity);

/* A convex solid of the caller's own class, with `inequalities` >= 1 functions f_i (see the top of
   this section for what is expected of them). `centre` is a point inside and `radius` > 0 that of a
   ball about it that holds the solid. cls->eval and cls->support must be there (ECP_BAD_POINTER);
   cls->hess is NULL if all f_i are affine; cls->mass may be NULL, and then ecp_shape_mass() gives
   no mass and no inertia. `cls` and `user` are kept by pointer; `user` may be NULL and is never read by the library.
   Fewer than one inequality gives ECP_BAD_SIZE. The class is tried along the six directions of the axes, so that
   `user` must be ready: a support point that is farther from `centre` than `radius`, or nearer along its direction
   than another one, is ECP_BAD_SUPPORT, and one that is no number ECP_NOT_FINITE. That the solid is convex, that eval
   and support mean the same one, and derivatives are not checked. Keep the frame's origin near the solid: from some
   sizes away on (in float; some hundreds in double) what is rounded costs steps. */
ECP_DEF ecp_status ecp_shape_convex(ecp_shape *s, const ecp_shape_class *cls, int inequalities,
                                    const ecp_real centre[3], ecp_real radius, const void *user);

/* Writes the shape's bounding box along the axes of its frame, exact up to rounding. A side on
   which the shape is unbounded is at +-1e30. `s` must be a shape that a constructor has filled; no
   pointer may be NULL. */
ECP_DEF void ecp_shape_bounds(const ecp_shape *s, ecp_real lo[3], ecp_real hi[3]);

/* Writes the shape's mass properties in its own frame, for a uniform density in kg/m^3. A negative
   density describes a cavity, to be added to the solid around it with ecp_mass_add(). A half-space
   gives no mass and no inertia. The same conditions on the pointers hold. */
ECP_DEF void ecp_shape_mass(const ecp_shape *s, ecp_real density, ecp_mass *out);

/* Adds to *total a part whose frame has its origin at `position` (m) and is turned by the
   quaternion `rotation` (w, x, y, z; it need not have unit length but must not be zero), both as
   seen from the frame of *total: a point p of the part is at position + R p. Start from an ecp_mass
   of zeros. A sum of zero mass leaves *total as it was. No pointer may be NULL, and *part may be
   *total. */
ECP_DEF void ecp_mass_add(ecp_mass *total, const ecp_mass *part, const ecp_real position[3],
                          const ecp_real rotation[4]);
/* >>world-api ============================================================================= */

/* A world is one block of the caller's memory. It holds offsets and no addresses into itself, so
   copying ecp_world_memsize() bytes to another aligned block makes an independent world, and
   copying them back restores it. Only the first ecp_world_state_size() bytes differ between calls;
   what follows is work memory, all zero outside a call. */
typedef struct ecp_world ecp_world;

typedef struct ecp_world_desc {
    int max_bodies;  /* all kinds together */
    int max_shapes;  /* posed primitives, over all bodies */
    int max_patches; /* pairs of primitives near enough to touch within one step */
    int max_inequalities; /* of the two primitives of one patch together, half-spaces none; a box has 6 */
    ecp_real gravity[3]; /* m/s^2, world frame */
    size_t solver_bytes; /* work memory for the elimination; 0: ecp_world_memsize() estimates it */
    int advance_order;   /* the highest order of ecp_advance, 2 to 12, and memory for it; 0: none */
} ecp_world_desc;

/* 8 bodies, 32 shapes, 16 patches of up to 12 inequalities, gravity (0, 0, -9.8). Most of it is work
   memory for the elimination. With solver_bytes = 0 it is enough for any scene of up to 8 bodies; for
   more, each is taken to have 12 neighbours when it is eliminated. A step that needs more returns
   ECP_CAPACITY with the bytes of the whole block that would do, an upper bound, in
   ecp_report.value, and those that there are in ecp_report.limit. solver_bytes must grow by the
   difference; where it was 0 it stood for what ecp_world_memsize() gives, less what it gives with
   solver_bytes = 8, and these 8. What it took then is in ecp_report.memory_used. */
ECP_DEF ecp_world_desc ecp_world_desc_default(void);

/* The bytes that ecp_world_init needs for this description, or 0 if it is out of range (1 to 4096 bodies, up to 100,000
   shapes and patches, 1 to 1000 inequalities, an advance_order of 0 or 2 to 12) or more than the machine addresses. */
ECP_DEF size_t ecp_world_memsize(const ecp_world_desc *desc);

/* Lays out an empty world in mem (at least memsize bytes, aligned to 8) and stores its address, mem
   itself, in *world. The block is the caller's to free. ECP_BAD_OPTION where ecp_world_memsize() gives 0,
   ECP_MEMORY_ALIGN and ECP_MEMORY_SMALL where it is of mem. */
ECP_DEF ecp_status ecp_world_init(ecp_world **world, const ecp_world_desc *desc, void *mem,
                                  size_t bytes);

/* The bytes at the start of the block that hold everything a snapshot needs. To go back, copy them to the start of
   the same block, or of another at least as large whose rest is zero (as ecp_world_init and every call leave it). */
ECP_DEF size_t ecp_world_state_size(const ecp_world *world);

/* Changes the gravity (m/s^2, world frame) of all steps to come. */
ECP_DEF ecp_status ecp_world_set_gravity(ecp_world *world, const ecp_real gravity[3]);

/* One more than the highest index of a body, or of a shape, that is in the world. Indices that
   ecp_body_remove has freed lie between the others, and count; ecp_body_get_state and ecp_shape_get,
   with NULL for all that they could give, return ECP_OK where there is a body, or a shape. */
ECP_DEF int ecp_world_body_count(const ecp_world *world);
ECP_DEF int ecp_world_shape_count(const ecp_world *world);

typedef enum ecp_body_kind {
    ECP_STATIC,    /* never moves */
    ECP_KINEMATIC, /* moves with the velocity it is given, whatever it meets */
    ECP_DYNAMIC    /* moves by equ:discrete_NE */
} ecp_body_kind;

/* A body's frame has its origin at the centre of mass. */
typedef struct ecp_body_desc {
    ecp_body_kind kind;
    ecp_real mass;        /* kg; of dynamic bodies only, nobody looks at that of others */
    ecp_real inertia[9];  /* kg m^2, about the centre of mass, body axes, row major */
    ecp_real position[3]; /* of the centre of mass, m, world */
    ecp_real rotation[4]; /* quaternion (w, x, y, z), body to world; normalised for you */
    ecp_real velocity[3]; /* of the centre of mass, m/s, world; a static body's are ignored */
    ecp_real angular_velocity[3]; /* rad/s, world ("spatial angular velocity" of the paper) */
} ecp_body_desc;

/* A dynamic body of 1 kg and inertia 1 kg m^2 at rest at the origin. */
ECP_DEF ecp_body_desc ecp_body_desc_default(void);

/* Adds a body; its index goes to *body (if not NULL). It is the lowest one that is free: counted from
   0 in the order of the calls, as long as no body is removed. ECP_CAPACITY where the world is full; of dynamic bodies
   also ECP_BAD_MASS, ECP_BAD_INERTIA, ECP_BAD_INERTIA_TRIANGLE; ECP_BAD_KIND where kind is none. */
ECP_DEF ecp_status ecp_body_add(ecp_world *world, const ecp_body_desc *desc, int *body);

/* Removes a body and its shapes, between steps. All other bodies and shapes keep their indices and
   the history of their contacts; the contacts of the removed shapes are no longer reported, and what
   lay on them falls in the next step. The indices that are free now return ECP_BAD_INDEX until a body
   or a shape that is added takes them, and cost nothing in a step. */
ECP_DEF ecp_status ecp_body_remove(ecp_world *world, int body);

/* Friction of a primitive's surface: the ellipsoid law (equation:friction) with the coefficient mu
   and the constants e_t, e_o (dimensionless) and e_r (a length: torsion e_r mu p_n). Between two
   primitives mu and the e are the geometric means, so that e_r = 0, the default, of either leaves their
   contact without friction against turning on the spot, face on face too. Where e_t differs from e_o,
   e_t holds along `direction`, a vector of the primitive's frame projected on the contact plane
   (without one: along some axis of the world); the primitive that has a direction (not zero) gives
   it, the one of lower index if both have. It is taken where the step begins; along a normal that it
   is within 1e-3 of it means nothing, and an axis of the world takes its place. */
typedef struct ecp_material {
    ecp_real mu;
    ecp_real e_t, e_o, e_r;
    ecp_real direction[3];
} ecp_material;

/* mu = 0.5, e = (1, 1, 0), no direction. */
ECP_DEF ecp_material ecp_material_default(void);

/* Adds a primitive to a body, posed in the body's frame by position (NULL: the origin) and rotation
   (NULL: none). The shape and the material (NULL: the default) are copied; what the shape points to
   (planes and vertices of a polytope, user data) is not and must outlive the world. The index, the
   lowest free one over all bodies, goes to *shape_index (if not NULL). Primitives of one body never
   touch each other. ECP_CAPACITY where the world is full, or one primitive has more inequalities than
   the description allows for two (two primitives that meet and have more are ECP_CAPACITY of the step); ECP_BAD_KIND of
   a half-space on a dynamic body; ECP_BAD_FRICTION, ECP_BAD_ELLIPSOID of a material. */
ECP_DEF ecp_status ecp_body_add_shape(ecp_world *world, int body, const ecp_shape *shape,
                                      const ecp_real position[3], const ecp_real rotation[4],
                                      const ecp_material *material, int *shape_index);

/* A body's state; every pointer may be NULL. In set, NULL keeps what is there, and so do values that get has given,
   to the last bit: they leave a sleeping body asleep. Setting the velocity of a kinematic body is how it is driven;
   a static body takes a pose only (ECP_BAD_KIND where a velocity is not zero). Bodies that are put into each other are
   parted in the next step and fly on with depth / h each, which adds up along a row. The history of its contacts and
   the loads on it stay: to begin anew with the same bits copy a snapshot back, or remove all bodies and add them. */
ECP_DEF ecp_status ecp_body_get_state(const ecp_world *world, int body, ecp_real position[3],
                                      ecp_real rotation[4], ecp_real velocity[3],
                                      ecp_real angular_velocity[3]);
ECP_DEF ecp_status ecp_body_set_state(ecp_world *world, int body, const ecp_real position[3],
                                      const ecp_real rotation[4], const ecp_real velocity[3],
                                      const ecp_real angular_velocity[3]);

/* Loads on a dynamic body: forces (N), torques (N m) and impulses (N s, N m s) in world axes, at a world point (NULL:
   the centre of mass). They add up, act in the next step that succeeds (forces over its h, impulses at once) and are
   then cleared: of two shorter steps in place of one that was not solved, the second needs its forces again.
   ecp_body_clear_loads() takes back all that has not acted yet. ECP_BAD_KIND where the body is not dynamic,
   ECP_NOT_FINITE also where the sum is not. */
ECP_DEF ecp_status ecp_body_apply_force(ecp_world *world, int body, const ecp_real force[3],
                                        const ecp_real *point);
ECP_DEF ecp_status ecp_body_apply_torque(ecp_world *world, int body, const ecp_real torque[3]);
ECP_DEF ecp_status ecp_body_apply_impulse(ecp_world *world, int body, const ecp_real impulse[3],
                                          const ecp_real *point);
ECP_DEF ecp_status ecp_body_apply_angular_impulse(ecp_world *world, int body,
                                                  const ecp_real impulse[3]);
ECP_DEF ecp_status ecp_body_clear_loads(ecp_world *world, int body);

/* The primitive with this index, its body, and its pose in the world: position, and the rotation as a 3 x 3 matrix,
   row major. Every pointer may be NULL. *shape is in the world's block, good until the body is removed. */
ECP_DEF ecp_status ecp_shape_get(const ecp_world *world, int shape_index, const ecp_shape **shape,
                                 int *body, ecp_real position[3], ecp_real rotation[9]);

/* Which primitives a primitive may touch: `category` has the bits of what it is, `collides_with`
   those of what it meets. Two primitives make a patch only if each one's category has a bit in common
   with what the other collides with. All bits of both are set where nothing is said, so such a
   primitive is of every category: with collides_with = 0 a primitive touches nothing, with any bit set
   also all that was left as it was. It holds from the next step on. Two that overlap when a step begins
   to see them are pushed apart within that step, as any two are: at the speed of depth / h. */
ECP_DEF ecp_status ecp_shape_set_filter(ecp_world *world, int shape_index, uint32_t category,
                                        uint32_t collides_with);

/* Gives a primitive another material (NULL: the default) from the next step on: a floor that turns to ice,
   a gripper whose pads get wet. The material is copied; one that is refused (ECP_BAD_FRICTION,
   ECP_BAD_ELLIPSOID), or is there already, changes nothing. */
ECP_DEF ecp_status ecp_shape_set_material(ecp_world *world, int shape_index,
                                          const ecp_material *material);

/* >>step-api ============================================================================== */

/* With two or more patches on a body the equations have many solutions (docs/model.md); the rule
   says which one is taken. */
typedef enum ecp_rule {
    ECP_CENTRED, /* the ECPs nearest to the centres of their primitives (of two that meet the
                    smaller one's), then the least impulses; ecp_report.centred says whether
                    that was reached */
    ECP_NEAREST  /* the one Newton reaches from the guess, the last step's solution */
} ecp_rule;

/* The ways out when Newton stalls from the warm start, tried in the order WORKING_SET, GEOMETRIC, LOAD, CONTINUATION,
   MULTISTART, CHORD, SUBSTEPS (their numbers are not the order). Where three bodies and more meet, sub-steps are
   tried right after ECP_FALLBACK_GEOMETRIC (in large heaps ECP_FALLBACK_CONTINUATION), and the others after them. */
enum {
    ECP_FALLBACK_GEOMETRIC = 1, /* start from support points at the pose free motion predicts, and
                                      from several points a patch with rough impulses; bodies that
                                      stand still and move in the solution found stand by such a
                                      start, if friction can hold them */
    ECP_FALLBACK_CONTINUATION = 2, /* smoothed complementarity and contacts that give way,
                                      both taken to zero */
    ECP_FALLBACK_MULTISTART = 4,   /* Newton from other starts, a fixed sequence: geometric ones of
                                      other motions and points; of ecp_mcp_solve disturbed ones */
    ECP_FALLBACK_LOAD = 8,         /* the loads and velocities of the step grow from nothing */
    ECP_FALLBACK_SUBSTEPS = 16,    /* shorter steps, each solved like a step, up to 256 of them;
                                      ecp_report.substeps says how many. Contacts and
                                      ecp_printed_residual are then those of the last of them.
                                      Also for a solution whose contacts win energy, which is one
                                      far away (ecp_report.work), or whose bodies turn through each
                                      other (ecp_report.midway), if there is another way */
    ECP_FALLBACK_CHORD = 32,       /* before sub-steps, all of the others with the slip measured by
                                      what the step moves the points in contact, over h, and not
                                      by velocities at its end (they differ by h w^2 r / 2): for
                                      bodies that hold each other and turn, often the only way.
                                      Again after them, for a solution whose contacts win energy.
                                      ecp_printed_residual is not small then */
    ECP_FALLBACK_WORKING_SET = 64  /* only the pairs with half-spaces and those that carried
                                      something in the last step, then those as well that overlap
                                      without, in up to 40 attempts. Pairs that end the step apart
                                      and carry nothing may have no contact then; a step that
                                      leaves some out so is not centred */
};

typedef struct ecp_options {
    ecp_rule rule;
    ecp_real tolerance; /* of the natural residual in scaled units: 1 is the momentum m vs, the
                           gap h vs and the velocity vs, where vs is the fastest free velocity,
                           or g h at rest. Rounding floors are added to it; in float normals are
                           held closer where they can be (docs/numerics.md). More than 0; one that
                           rounding does not reach is taken, the floors apply */
    int max_iterations; /* 1 or more: Newton iterations of one attempt; four times as many where its steps
                           have to be damped, eight times in islands of two and more bodies
                           with 1500 unknowns and more */
    int max_total_iterations; /* of all attempts, islands, sub-steps and the centring together (but
                                 for one elimination in each of ecp_report.centring_rounds), or 0:
                                 as many as it takes. A bound on the time of a step: where it ends
                                 the search the step is ECP_NOT_SOLVED (one that has come below the
                                 tolerance is taken), and where it ends the centring
                                 ecp_report.centred is 0. See REAL TIME in the manual */
    int fallbacks;            /* ECP_FALLBACK_... that may be used, or-ed */
    int sleep; /* 1: islands at rest are left out of the problem until something changes.
                                 It changes no bit of any body or contact, see SLEEP in the manual */
    /* ecp_dump, or NULL: called for a step that ends in ECP_NOT_SOLVED, with these two, of which
       dump_write must not be NULL then (ECP_BAD_POINTER) */
    ecp_status (*dump)(const ecp_world *world, ecp_real h, const struct ecp_options *options,
                       void (*write)(void *user, const char *text), void *user);
    void (*dump_write)(void *user, const char *text);
    void *dump_user;
} ecp_options;

/* centred (nearest with ECPSIM_NO_CENTRING), 1e-12 (float: 1e-5), 40 iterations an attempt, no bound on all of them,
   all fallbacks that there are (ECPSIM_FALLBACKS), no sleep, no dump. */
ECP_DEF ecp_options ecp_options_default(void);

/* What a step did. */
typedef struct ecp_report {
    ecp_status status;
    int unknowns; /* scalar unknowns of the step's problem, all islands (of whole islands, also where
                         ECP_FALLBACK_WORKING_SET leaves some out) */
    int asleep;   /* dynamic bodies that the step left out because they sleep; their islands
                             are counted nowhere else, their patches are */
    int patches_kept; /* pairs of primitives in the problem, or asleep */
    int patches_left_out; /* all others (about INT_MAX if there are more): a filter parts them, they cannot
                             touch within the step, or touch at a corner (edge along edge, vertex to vertex), carried
                             nothing in the last step and do not overlap after this one; or they were
                             left out by ECP_FALLBACK_WORKING_SET and do not overlap */
    int islands;          /* groups of bodies that touch, each solved by itself */
    int iterations; /* Newton iterations, all attempts. Where bodies meet they are repeated with
                            the elimination they have, which `evaluations` alone counts */
    int centring_rounds; /* of the rule ECP_CENTRED */
    int centred;         /* 1: the rule reached its solution in every island that needed it; 0 with
                            ECP_NEAREST, and of a step that is not done */
    int evaluations;     /* residual evaluations, of an island each */
    int fallbacks;       /* ECP_FALLBACK_... that were used, or-ed */
    int substeps;        /* shorter steps that it took; 1 but for ECP_FALLBACK_SUBSTEPS. Of several,
                            unknowns, patches and islands are the last one's, and merit, natural_residual,
                            worst_gap, work, midway, worst_cone and centred the worst of all */
    int body, shape_a, shape_b; /* if status is not ECP_OK: where, or -1. An island that is not
                                   solved gives the patch whose equations are missed the most
                                   where its last attempt ended (ECPSIM_NO_PAIRS: its first) */
    ecp_real value, limit; /* if status is not ECP_OK: the value met and the one it must meet; the
                              depth and 0, where all that was found went through each other */
    ecp_real merit; /* |F|^2 / 2, friction rows weighed by their load, summed over the islands */
    ecp_real natural_residual; /* max |F_i|, as for the tolerance, rounding floors included */
    ecp_real worst_gap;        /* the least separation of a patch, m; below zero: penetration */
    ecp_real work;   /* the most that the contacts of an island add to its energy, in units of
                              twice the kinetic energy of its bodies (of each the most that it has
                              before, after, or in free motion), without twice what pushes overlaps
                              apart (as it turns bodies, their gaps are curved).
                              More than 0.01 is given up for sub-steps, where they may be used and
                              max_total_iterations leaves enough, and taken if they do no better:
                              with a bound look at it. (0 if ECPSIM_FALLBACKS is without them) */
    ecp_real midway; /* the most that two primitives in an island, one of which turns by more than
                              0.25 rad, overlap half way of the step, beyond what they did where it
                              began, in radii of the smaller one. (The equations see beginning and
                              end: a cube that turns by 90 degrees goes from face to face.) More than
                              0.02 is given up and taken as `work` is. (0 if ECPSIM_FALLBACKS is
                              without sub-steps) */
    ecp_real worst_cone;   /* how far a friction cone is left: max of |y| - mu p_n over the patches,
                              N s, or 0 where none is; y as in docs/model.md */
    ecp_real largest_turn; /* max of h |w| over the bodies, kinematic ones too, rad (of several
                              sub-steps in any one of them). A step that turns a body by more than
                              about 0.1 may have several solutions, of which the one nearest to the
                              start is taken */
    ecp_real dropped;   /* the largest velocity that a body has begun the step without, to come to
                                    rest on what carries it (docs/model.md), m/s; a turn times sqrt(trace I / mass) */
    size_t memory_used; /* high-water mark of the block, bytes */
} ecp_report;

/* Advances the world by h seconds: predicts, solves the equations of the paper for all bodies and
   patches together, verifies by support functions that nothing penetrates, and commits. options may
   be NULL (the defaults), report may be NULL. On any status but ECP_OK the whole block is bit for
   bit as it was. Bodies move by h times their velocity at the end of the step, up to the rounding of the
   gaps between them: the velocities that are kept balance the impulses. (Where bodies lie on bodies and nothing
   moves, what gaps are granted stays in the impulses reported: in float some 1e-3 of the load.)
   ECP_BAD_STEP of an h that is not positive, ECP_BAD_OPTION of options, ECP_NOT_SOLVED, ECP_CAPACITY, and
   ECP_NOT_FINITE where a pose or a turn h |w| grows out of range (its square overflows). */
ECP_DEF ecp_status ecp_step(ecp_world *world, ecp_real h, const ecp_options *options,
                            ecp_report *report);

/* Sets the guess for the equivalent contact point of a pair of primitives in the next step: a world
   point, kept in the frame of the primitive that the contact report calls A. It matters for the rule
   ECP_NEAREST, takes the place of the pair's last solution, and uses one of max_patches. ECP_BAD_KIND
   where the two can make no patch: on one body, neither on a dynamic one, two half-spaces, or no half-space with
   ECPSIM_NO_PAIRS; ECP_BAD_INDEX also where they are the same one; ECP_CAPACITY where max_patches are in use;
   ECP_BAD_OPTION within a callback of ecp_advance(). The pair's contact is no longer among ecp_contact_get()'s until
   the next step. */
ECP_DEF ecp_status ecp_guess_ecp(ecp_world *world, int shape_a, int shape_b,
                                 const ecp_real point[3]);

/* What a patch does: it has no load; it sticks; it slips, or has no friction (sigma is 0 then). */
typedef enum ecp_mode { ECP_APART, ECP_STICK, ECP_SLIP } ecp_mode;

/* A patch at the end of the last step. */
typedef struct ecp_contact {
    int shape_a,
        shape_b; /* indices of the primitives; B is the half-space, or has the higher index */
    int body_a, body_b;
    ecp_real point_a[3], point_b[3]; /* the ECP on both (a_1, a_2), m, world */
    ecp_real normal[3];              /* unit, from B to A: the direction in which p_n pushes A */
    ecp_real direction_t[3], direction_o[3]; /* unit tangents: (t, o, normal) is right-handed */
    ecp_real gap;                            /* m, along the normal */
    ecp_real separation;        /* m, of A and B by their support functions along the normal,
                                       as A or as B has it: the certificate; any value >= 0
                                       proves that they are apart */
    ecp_real p_n, p_t, p_o;     /* impulses on A along normal and tangents, N s (on B their
                                       opposites): over h the mean force, where ecp_report.substeps
                                       is 1; else they are of the last of these only */
    ecp_real p_r;               /* moment impulse on A about the normal, N m s */
    ecp_real sigma;             /* slip |(e_t v_t, e_o v_o, e_r w_n)|, m/s; zero unless it slips */
    ecp_real mu, e_t, e_o, e_r; /* the pair's friction */
    ecp_mode mode;
} ecp_contact;

/* How many patches the last step had, and one of them, by its index from 0; ECP_BAD_INDEX if there is none. Pairs
   that could touch in the step are patches, also those that it left apart, but for corners and others that it
   could do without (ecp_report.patches_left_out). */
ECP_DEF int ecp_contact_count(const ecp_world *world);
ECP_DEF ecp_status ecp_contact_get(const ecp_world *world, int index, ecp_contact *contact);

/* Writes the step that ecp_step(world, h, options, ..) would do now as C source, by calls of `write`
   with pieces of text that end in a zero byte. The source is one function,

       static ecp_status dumped_step(ecp_world **world, ecp_report *report)

   that makes the same world in malloced memory (*world, to be freed by the caller), with all that the
   step depends on and bit for bit, does the step, and returns its status. It belongs in a unit that
   has the implementation of this header, of the same version and the same real type, <stdlib.h> and
   <string.h>; C99 and C++11 take it. Numbers are decimal, with as many digits as the real type needs
   to come back by a compiler that rounds correctly, as all usual ones do.

   A class of the caller's own (ecp_shape_convex) cannot be written. The source then compiles all the
   same, says where the class is missing, and returns ECP_BAD_KIND before the step; and so does
   ecp_dump. Bad options or a bad h get the status that ecp_step gives them, and nothing is written.
   The world is only read. */
ECP_DEF ecp_status ecp_dump(const ecp_world *world, ecp_real h, const ecp_options *options,
                            void (*write)(void *user, const char *text), void *user);

/* >>advance-api =========================================================================== */

/* A step is first order: its error falls in proportion to the work. ecp_advance() reaches a time
   within a tolerance, by extrapolation of base steps (those of ecp_step) over macro steps whose
   length and order it chooses, and locates what happens in between: landings, lift-offs, slip that
   stops or begins or turns round, faces that become edges (docs/advance.md). It works in the world's
   own memory, if ecp_world_desc.advance_order asks for it. */

/* Called before every base step with the world in its state there, and the time at the step's end: applies the loads
   (ecp_body_apply_force, ecp_body_apply_torque), and sets the velocities of kinematic bodies. It must be a function
   of both alone, as base steps are repeated, and no impulses belong there: they would act in every base step.
   ecp_step, ecp_advance, ecp_dump and what adds or removes bodies and shapes are ECP_BAD_OPTION there; nothing else is
   to be changed there either, which is not checked. It is also asked as a macro step begins, and once more for all of
   these times and that of the beginning before one is accepted, so that a load which begins or ends is found. It is
   seen at these times only: what comes and goes between two of them is not there. While little moves they are seconds
   apart, so give a load that varies a longest_step, of a fraction of what it takes. */
typedef void (*ecp_load)(void *user, ecp_world *world, ecp_real time);

typedef struct ecp_advance_options {
    ecp_real tolerance;  /* what the error of one macro step may be: in positions and turns
                            tolerance times L = sqrt(trace I / mass) of the body (of a kinematic
                            one: the shortest L, or 1 m), and tolerance (rad); in velocities
                            tolerance times the largest of |v|, L |w| and sqrt(a L), where a is
                            the largest acceleration by gravity or a load, of any body */
    ecp_real macro_step; /* s; 0: chosen. Else this pace is kept (the last one is shorter), with
                            `order`, and the tolerance is only the unit of the error reported */
    int order;           /* the highest, from 2 to ecp_world_desc.advance_order; 0: that one */
    int max_solves;      /* base steps, after which it fails with ECP_NOT_SOLVED, looked at between
                            macro steps; 0: no limit. What one of them may take, `step` bounds */
    ecp_real time;       /* at the beginning, for `load`, s */
    ecp_load load;       /* or NULL */
    void *load_user;
    const ecp_options *step; /* of the base steps, or NULL; `sleep` and `dump` mean nothing there */
    ecp_real longest_step;   /* of a chosen macro step, s; 0: as long as the tolerance lets it be */
} ecp_advance_options;

/* 1e-6 (float: 1e-3), all chosen, no callback. */
ECP_DEF ecp_advance_options ecp_advance_options_default(void);

typedef struct ecp_advance_report {
    ecp_status status;
    ecp_real reached; /* s from the beginning, also of a call that failed */
    int macro_steps;  /* accepted */
    int rejected;     /* and begun in vain */
    int solves;       /* base steps, all */
    int events;       /* changes of the contacts that were passed */
    int first_order;  /* macro steps that were passed at first order: a change lies in them, or they
                         were forced */
    int forced;       /* of these, not within the tolerance: events too dense to be told apart,
                            or a base step that only the fallbacks of ecp_step solve */
    int highest_order;
    ecp_real shortest; /* macro step, s */
    ecp_real error;    /* the largest estimate of an accepted macro step, in tolerances; 2 also
                          where only the fallbacks solve, whose error is not known */
    ecp_real
        projection;  /* the largest gap or overlap that extrapolation left and that was closed, m */
    ecp_report step; /* of the last base step */
} ecp_advance_report;

/* Advances the world by `duration` seconds (0 or more). options and report may be NULL. Forces that
   were applied before the call act throughout, impulses at its beginning; both are then cleared.
   Contacts are afterwards those of the last base step (their impulses belong to its length), with the
   gaps and points of the pose that was reached, along the normals that they had: where a body has slid off
   an edge since, such a gap can be negative though nothing overlaps. A world at rest costs next to nothing,
   however long.
   Primitives that overlap are moved apart first, at rest: they keep their velocities (ecp_step would
   give them depth / h, which has no limit where steps have no length).

   On any status but ECP_OK the whole block is bit for bit as it was: ECP_CAPACITY where the
   description has not this order, ECP_TOLERANCE where the tolerance is below what rounding leaves (16
   times that of the base steps, or 64 rounding units times 1 + the distance from the origin over L),
   ECP_BAD_STEP for a negative duration or a pace or a longest step that is nothing beside it, ECP_BAD_OPTION (also
   within its own callback), ECP_NOT_FINITE, and those of ecp_step. */
ECP_DEF ecp_status ecp_advance(ecp_world *world, ecp_real duration,
                               const ecp_advance_options *options, ecp_advance_report *report);

/* >>check-api ============================================================================= */

/* The equations as they are printed in the paper, evaluated on a finished step: `before` is a copy
   of the world's block taken before it, `after` the world after it. Each residual is the largest
   over bodies or patches, divided by the scale of its terms. */
typedef struct ecp_printed {
    ecp_real newton_euler; /* equ:discrete_NE; the gyroscopic moment as the step takes it */
    ecp_real kinematic;    /* equ:kinematic, renormalised */
    ecp_real friction;     /* equation:friction */
    ecp_real friction_c;   /* equation:friction_c */
    ecp_real contact_1;    /* equation:re_contact_multiple_1 */
    ecp_real contact_2;    /* equation:re_contact_multiple_2 */
    ecp_real contact_3;    /* equation:re_contact_multiple_3 */
    ecp_real contact_4;    /* equation:re_contact_multiple_4 */
    ecp_real contact_5;    /* equation:re_contact_multiple_5 */
    ecp_real largest;
} ecp_printed;

/* ECP_CAPACITY where the description has more than 64 inequalities, ECP_BAD_INDEX where the two have other numbers of
   bodies or shapes, ECP_BAD_STEP of an h that is not positive. */
ECP_DEF ecp_status ecp_printed_residual(const ecp_world *before, const ecp_world *after, ecp_real h,
                                        ecp_printed *printed);

/* One step of a body in pure translation on a plane, in closed form (equation:impulse_t to _n, with
   the signs and the stick branch that the paper leaves out; isotropic friction e). In: mass, unit
   normal, mu, e, applied impulse J (weight included), velocity v, which must not leave the plane.
   Out: the velocity after the step and the summed impulse of the plane on the body (normal and
   friction together). Returns ECP_SLIP, ECP_STICK, or ECP_APART where J lifts the body off. Nothing is
   checked: mass > 0, |normal| = 1, and no pointer may be NULL. */
ECP_DEF ecp_mode ecp_translation_step(ecp_real mass, const ecp_real normal[3], ecp_real mu,
                                      ecp_real e, const ecp_real J[3], const ecp_real v[3],
                                      ecp_real v_out[3], ecp_real impulse[3]);

/* >>mcp-api =============================================================================== */

/* A mixed complementarity problem in z[n + m]: the first n components of F are zero,
   F_i(z) = 0; for each of the last m, z_i >= 0, F_i >= 0, z_i F_i = 0. */
typedef struct ecp_mcp {
    int n, m;
    void (*function)(void *user, const ecp_real *z, ecp_real *F); /* F[n + m] */
    /* J[(n + m)^2], row major; all of it, zeros too */
    void (*jacobian)(void *user, const ecp_real *z, ecp_real *J);
    void *user;
} ecp_mcp;

typedef struct ecp_mcp_report {
    int iterations, evaluations;
    int fallbacks;             /* ECP_FALLBACK_CONTINUATION, ECP_FALLBACK_MULTISTART */
    ecp_real natural_residual; /* the largest component of the Fischer-Burmeister residual */
    ecp_real merit;
} ecp_mcp_report;

/* The bytes that ecp_mcp_solve needs for n equations and m complementarities, or 0 if either is
   negative or above 10,000, or both are zero. */
ECP_DEF size_t ecp_mcp_memsize(int n, int m);

/* Solves the problem from the start in z, and leaves the solution there. options (tolerance: of the
   largest component of the Fischer-Burmeister residual; NULL: the defaults) and report may be NULL.
   If it is not solved, z is as it was. F is to be in units in which it is about 1: a residual of 4
   roundings (4 FLT_EPSILON or DBL_EPSILON) will do whatever the tolerance. Unknowns may be in any, but
   where Newton alone does not do, damping and other starts are of size 1. The report is written if the
   status is ECP_OK or ECP_NOT_SOLVED. mem: ecp_mcp_memsize(n, m) bytes, aligned to 8 (ECP_MEMORY_SMALL,
   ECP_MEMORY_ALIGN). ECP_BAD_OPTION of n and m where that is 0, and of options. */
ECP_DEF ecp_status ecp_mcp_solve(const ecp_mcp *problem, const ecp_options *options, ecp_real *z,
                                 void *mem, size_t bytes, ecp_mcp_report *report);

#ifdef __cplusplus
}
#endif

#endif /* ECPSIM_H */

/* >>linear ================================================================================ */

#ifdef ECPSIM_IMPLEMENTATION
#ifndef ECPSIM_IMPLEMENTED
#define ECPSIM_IMPLEMENTED

/* Overrides of the C library: all or none of a group. */
#ifndef ECPSIM_SQRT
#include <math.h>
#ifdef ECPSIM_FLOAT
#define ECPSIM_SQRT sqrtf
#else
#define ECPSIM_SQRT sqrt
#endif
#endif
#if defined(ECPSIM_MEMCPY) != defined(ECPSIM_MEMSET)
#error "ecpsim.h: define both of ECPSIM_MEMCPY and ECPSIM_MEMSET, or none"
#endif
#ifndef ECPSIM_MEMCPY
#include <string.h>
#define ECPSIM_MEMCPY memcpy
#define ECPSIM_MEMSET memset
#endif
#ifndef ECPSIM_ASSERT
#include <assert.h>
#define ECPSIM_ASSERT assert
#endif

#define ECP_R(x) ((ecp_real)(x))

/* What a program can do without (see the manual), as constants of ordinary conditions: what these
   exclude is still compiled, and then dropped. */
#ifdef ECPSIM_NO_PAIRS
#define ECP_I_PAIRS 0
#else
#define ECP_I_PAIRS 1
#endif
#ifdef ECPSIM_NO_FRICTION
#define ECP_I_FRICTION 0
#else
#define ECP_I_FRICTION 1
#endif
#ifdef ECPSIM_NO_SLEEP
#define ECP_I_SLEEP 0
#else
#define ECP_I_SLEEP 1
#endif
#ifdef ECPSIM_NO_CENTRING
#define ECP_I_CENTRING 0
#else
#define ECP_I_CENTRING 1
#endif
#ifndef ECPSIM_FALLBACKS
#define ECPSIM_FALLBACKS                                                                           \
    (ECP_FALLBACK_GEOMETRIC | ECP_FALLBACK_CONTINUATION | ECP_FALLBACK_MULTISTART |                \
     ECP_FALLBACK_LOAD | ECP_FALLBACK_SUBSTEPS | ECP_FALLBACK_CHORD | ECP_FALLBACK_WORKING_SET)
#endif

/* Where size is asked for, what only saves time is left out: inner loops are not written out, and what comes to
   nothing is worked out all the same. The sums and their bits are the same. */
#ifdef __OPTIMIZE_SIZE__
#define ECP_I_FAST 0
#else
#define ECP_I_FAST 1
#endif

/* the spacing of the reals at 1: all tolerances for rounding are multiples of it */
#ifdef ECPSIM_FLOAT
#define ECP_I_EPSILON ECP_R(1.1920929e-7f)
#else
#define ECP_I_EPSILON ECP_R(2.220446049250313e-16)
#endif

#ifdef __cplusplus
extern "C" {
#endif

static ecp_real ecp_i_sqrt(ecp_real x) { return ECPSIM_SQRT(x); }
/* in this form compilers have an instruction for each */
static ecp_real ecp_i_max(ecp_real a, ecp_real b) { return a > b ? a : b; }
static ecp_real ecp_i_min(ecp_real a, ecp_real b) { return a < b ? a : b; }

/* *most = max(*most, value) */
static void ecp_i_raise(ecp_real *most, ecp_real value)
{
    if (!(*most > value)) *most = value;
}

/* |x|: one instruction where the compiler offers it by name. It does not find it in the last form, as
   -0 has to lose its sign. */
static ecp_real ecp_i_abs(ecp_real x)
{
#if defined(__GNUC__) && defined(ECPSIM_FLOAT)
    return __builtin_fabsf(x);
#elif defined(__GNUC__)
    return __builtin_fabs(x);
#else
    return x > 0 ? x : 0 - x;
#endif
}

/* The power of two at or below x > 0: units are such powers, so that scaling by them rounds nothing. */
static ecp_real ecp_i_power_of_two(ecp_real x)
{
    ecp_real unit = 1;
    if (!(x > 0) || x - x != 0) return 1;
    while (ECP_I_FAST && unit * 65536 <= x) unit *= 65536;
    while (unit * 2 <= x) unit *= 2;
    while (ECP_I_FAST && unit * (1 / ECP_R(65536)) > x) unit *= 1 / ECP_R(65536);
    while (unit > x) unit *= ECP_R(0.5);
    return unit;
}

/* false for NaN and infinity */
static int ecp_i_finite(ecp_real x) { return x - x == 0; }

/* *worst = max(*worst, value), where NaN is the largest of all and stays */
static void ecp_i_worst(ecp_real *worst, ecp_real value)
{
    if (value <= *worst) return;
    if (value > *worst || value != value) *worst = value;
}

static int ecp_i_all_finite(int n, const ecp_real *x)
{
    ecp_real zero = 0;
    int i;
    for (i = 0; i < n; i++) zero += x[i] - x[i];
    return zero == 0;
}

#ifdef ECPSIM_FLOAT
#define ECP_I_SMALLEST ECP_R(1.17549435e-38f) /* of full precision */
#else
#define ECP_I_SMALLEST ECP_R(2.2250738585072014e-308)
#endif

ECP_DEF int ecp_arithmetic(void)
{
    /* what compilers must take from memory they can not work out beforehand */
    volatile ecp_real in[9] = {1, ECP_I_EPSILON, ECP_I_SMALLEST, 3, 10, 2, 0, 0, 0}, out[3];
    ecp_real one = in[0], eps = in[1], smallest = in[2], three = in[3], ten = in[4], two = in[5];
    ecp_real below = one - eps, above = one + eps, nan;
    int flags = 0;
    out[0] = one + eps;
    out[1] = one + eps / 4;
    if (sizeof(ecp_real) * 8 != (ECP_I_EPSILON < ECP_R(1e-9) ? 64 : 32) || !(out[0] > one) ||
        out[1] > out[0]) {
        flags |= ECP_ARITHMETIC_FORMAT;
    }
    if ((one + eps / 4) - one != 0 && !(out[1] > one)) flags |= ECP_ARITHMETIC_EXCESS;
    /* ties: down to 1, up to 1 + 2 eps; then what is nearer */
    out[0] = one + eps / 2;
    out[1] = out[0] - one;
    if (out[1] != 0) flags |= ECP_ARITHMETIC_ROUNDING;
    out[0] = above + eps / 2;
    out[1] = -one - 3 * eps / 4;
    if (out[0] != one + 2 * eps || out[1] != -one - eps) flags |= ECP_ARITHMETIC_ROUNDING;
    out[0] = one + 3 * eps / 4;
    if (out[0] != above) flags |= ECP_ARITHMETIC_ROUNDING;
    out[0] = smallest / 4;
    out[1] = out[0] * 4;
    if (!(out[0] > 0) || out[1] != smallest) flags |= ECP_ARITHMETIC_SUBNORMAL;
    /* (1 + eps) (1 - eps) = 1 - eps^2, and 1 when it is rounded */
    if (!(flags & (ECP_ARITHMETIC_EXCESS | ECP_ARITHMETIC_ROUNDING)) && above * below - one != 0) {
        flags |= ECP_ARITHMETIC_CONTRACTED;
    }
    /* three of them: fewer are not worth a reciprocal to compilers that may take one */
    out[0] = one / three;
    out[1] = ten / three;
    out[2] = two / three;
    if (out[0] != ECP_R(1) / ECP_R(3) || out[1] != ECP_R(10) / ECP_R(3) ||
        out[2] != ECP_R(2) / ECP_R(3)) {
        flags |= ECP_ARITHMETIC_INEXACT;
    }
    out[0] = ecp_i_sqrt(two);
    out[1] = ecp_i_sqrt(one + 2 * eps);
    if (out[0] != ECP_R(1.4142135623730951) || out[1] != above) flags |= ECP_ARITHMETIC_INEXACT;
    out[0] = ecp_i_sqrt(three);
    if (out[0] != ECP_R(1.7320508075688772)) flags |= ECP_ARITHMETIC_INEXACT;
    nan = in[6] / in[7];
    if (ecp_i_finite(nan) || nan == nan || nan > 0) flags |= ECP_ARITHMETIC_NAN;
    return flags;
}

/* >>vectors: 3-vectors and 3 x 3 matrices; outputs last, and never an alias of an input unless said */

static void ecp_i_set3(ecp_real a, ecp_real b, ecp_real c, ecp_real out[3])
{
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/* copies n reals; compilers write out what memcpy is asked for, which is as large as it is fast */
static void ecp_i_copy(int n, const ecp_real *x, ecp_real *out)
{
    int i;
    if (ECP_I_FAST) ECPSIM_MEMCPY(out, x, (size_t)n * sizeof(ecp_real));
    for (i = 0; !ECP_I_FAST && i < n; i++) out[i] = x[i];
}

static void ecp_i_copy3(const ecp_real a[3], ecp_real out[3])
{
    int k;
    for (k = 0; k < 3; k++) out[k] = a[k];
}

static int ecp_i_equal(const ecp_real a[3], const ecp_real b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static int ecp_i_same_bytes(const void *a, const void *b, size_t bytes)
{
    const unsigned char *p = (const unsigned char *)a, *q = (const unsigned char *)b;
    size_t i;
    for (i = 0; i < bytes; i++) {
        if (p[i] != q[i]) return 0;
    }
    return 1;
}

static int ecp_i_is_zero(const ecp_real a[3]) { return a[0] == 0 && a[1] == 0 && a[2] == 0; }

static ecp_real ecp_i_dot(const ecp_real a[3], const ecp_real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static ecp_real ecp_i_norm(const ecp_real a[3]) { return ecp_i_sqrt(ecp_i_dot(a, a)); }

static void ecp_i_cross(const ecp_real a[3], const ecp_real b[3], ecp_real out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out = a + s b; out may be a or b */
static void ecp_i_axpy(const ecp_real a[3], ecp_real s, const ecp_real b[3], ecp_real out[3])
{
    out[0] = a[0] + s * b[0];
    out[1] = a[1] + s * b[1];
    out[2] = a[2] + s * b[2];
}

static void ecp_i_add(const ecp_real a[3], const ecp_real b[3], ecp_real out[3])
{
    ecp_i_axpy(a, 1, b, out);
}

static void ecp_i_sub(const ecp_real a[3], const ecp_real b[3], ecp_real out[3])
{
    ecp_i_axpy(a, -1, b, out);
}

static void ecp_i_scale(ecp_real s, const ecp_real a[3], ecp_real out[3])
{
    ecp_i_set3(s * a[0], s * a[1], s * a[2], out);
}

/* out += a x b */
static void ecp_i_add_cross(const ecp_real a[3], const ecp_real b[3], ecp_real out[3])
{
    ecp_real c[3];
    ecp_i_cross(a, b, c);
    ecp_i_add(out, c, out);
}

/* The velocity v of A relative to B at a point that is at ra and rb from where A and B move with va and vb
   (linear, then angular). */
static void ecp_i_relative_velocity(const ecp_real *va, const ecp_real *vb, const ecp_real ra[3],
                                    const ecp_real rb[3], ecp_real v[3])
{
    ecp_i_sub(va, vb, v);
    ecp_i_add_cross(va + 3, ra, v);
    ecp_i_add_cross(rb, vb + 3, v);
}

/* inline: these two are called so often that the calls were a twentieth of a step */
static inline void ecp_i_mul(const ecp_real A[9], const ecp_real x[3], ecp_real out[3])
{
    out[0] = ecp_i_dot(A, x);
    out[1] = ecp_i_dot(A + 3, x);
    out[2] = ecp_i_dot(A + 6, x);
}

/* out = A^T x */
static inline void ecp_i_mul_t(const ecp_real A[9], const ecp_real x[3], ecp_real out[3])
{
    ecp_real x0 = x[0], x1 = x[1], x2 = x[2];
    out[0] = A[0] * x0 + A[3] * x1 + A[6] * x2;
    out[1] = A[1] * x0 + A[4] * x1 + A[7] * x2;
    out[2] = A[2] * x0 + A[5] * x1 + A[8] * x2;
}

/* out = A B, row by row */
static void ecp_i_matmul(const ecp_real A[9], const ecp_real B[9], ecp_real out[9])
{
    ecp_i_mul_t(B, A, out);
    ecp_i_mul_t(B, A + 3, out + 3);
    ecp_i_mul_t(B, A + 6, out + 6);
}

/* out = R A R^T */
static void ecp_i_congruence(const ecp_real R[9], const ecp_real A[9], ecp_real out[9])
{
    ecp_real T[9];
    ecp_i_matmul(R, A, T);
    ecp_i_mul(R, T, out);
    ecp_i_mul(R, T + 3, out + 3);
    ecp_i_mul(R, T + 6, out + 6);
}

/* ecp_chol_factor of a 3 x 3 matrix, written out for speed; 0 where it is not positive definite */
static int ecp_i_cholesky3(ecp_real A[9])
{
    ecp_real d = A[0];
    if (!(d > 0)) return 0;
    A[0] = ecp_i_sqrt(d);
    A[3] /= A[0];
    A[6] /= A[0];
    d = A[4] - A[3] * A[3];
    if (!(d > 0)) return 0;
    A[4] = ecp_i_sqrt(d);
    A[7] = (A[7] - A[6] * A[3]) / A[4];
    d = A[8] - A[6] * A[6] - A[7] * A[7];
    if (!(d > 0)) return 0;
    A[8] = ecp_i_sqrt(d);
    return 1;
}

/* b = A^-1 b for such a matrix, in the order of ecp_chol_solve */
static void ecp_i_solve3(const ecp_real A[9], ecp_real b[3])
{
    ecp_real L[9];
    ecp_i_copy(9, A, L);
    ecp_i_cholesky3(L);
    b[0] /= L[0];
    b[1] = (b[1] - L[3] * b[0]) / L[4];
    b[2] = (b[2] - L[6] * b[0] - L[7] * b[1]) / L[8];
    b[2] /= L[8];
    b[1] = (b[1] - L[7] * b[2]) / L[4];
    b[0] = (b[0] - L[3] * b[1] - L[6] * b[2]) / L[0];
}

static int ecp_i_normalise(ecp_real a[3])
{
    ecp_real size = ecp_i_norm(a);
    if (!(size > 0)) return 0;
    ecp_i_scale(1 / size, a, a);
    return 1;
}

ECP_DEF void ecp_quat_to_matrix(const ecp_real q[4], ecp_real R[9])
{
    ecp_real w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - 2 * (y * y + z * z);
    R[1] = 2 * (x * y - w * z);
    R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z);
    R[4] = 1 - 2 * (x * x + z * z);
    R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y);
    R[7] = 2 * (y * z + w * x);
    R[8] = 1 - 2 * (x * x + y * y);
}

ECP_DEF void ecp_quat_multiply(const ecp_real a[4], const ecp_real b[4], ecp_real out[4])
{
    ecp_real w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    ecp_real x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    ecp_real y = a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3];
    ecp_real z = a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1];
    out[0] = w;
    out[1] = x;
    out[2] = y;
    out[3] = z;
}

/* Of unit length, but for rounding: divided by a length that is nothing else, q would come and go between two values,
   and what it is the orientation of would not rest. 0 if it is zero. */
static int ecp_i_quat_normalise(ecp_real q[4])
{
    ecp_real size = ecp_i_sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    int k;
    if (!(size > 0)) return 0;
    if (ecp_i_abs(size - 1) <= 2 * ECP_I_EPSILON) return 1;
    for (k = 0; k < 4; k++) q[k] /= size;
    return 1;
}

/* A quaternion from outside, whose length may be any but zero, scaled by a power of two, which rounds
   nothing, so that no square overflows. */
static void ecp_i_quat_scaled(const ecp_real in[4], ecp_real q[4])
{
    ecp_real big = 0;
    int k;
    for (k = 0; k < 4; k++) big = ecp_i_max(big, ecp_i_abs(in[k]));
    big = ecp_i_power_of_two(big);
    for (k = 0; k < 4; k++) q[k] = in[k] / big;
}

/* the same with length one; 0 if it has no length */
static int ecp_i_quat_unit(const ecp_real in[4], ecp_real q[4])
{
    ecp_i_quat_scaled(in, q);
    return ecp_i_quat_normalise(q);
}

/* equ:kinematic for the rotation: q + h (0, w) q / 2 = (1, u) q with u = h w / 2, renormalised */
ECP_DEF void ecp_quat_advance(const ecp_real q[4], const ecp_real w[3], ecp_real h, ecp_real out[4])
{
    ecp_real turn[4];
    turn[0] = 1;
    ecp_i_scale(h / 2, w, turn + 1);
    ecp_quat_multiply(turn, q, out);
    ecp_i_quat_normalise(out);
}

/* the matrix of u x */
static void ecp_i_skew(const ecp_real u[3], ecp_real U[9])
{
    ecp_i_set3(0, -u[2], u[1], U);
    ecp_i_set3(u[2], 0, -u[0], U + 3);
    ecp_i_set3(-u[1], u[0], 0, U + 6);
}

/* The same turn as a matrix I + T, T = 2 / (1 + |u|^2) (U + U^2) with u = h w / 2, U = [u]x (kept
   without the identity, so that small turns lose no digits), and its left derivative: a change dw
   of w turns the result further by J dw, J = h / (1 + |u|^2) (I + U). */
static void ecp_i_cayley(const ecp_real w[3], ecp_real h, ecp_real T[9], ecp_real J[9])
{
    ecp_real u[3], uu, s;
    int i, j;
    ecp_i_scale(h / 2, w, u);
    uu = ecp_i_dot(u, u);
    s = 1 / (1 + uu);
    ecp_i_skew(u, J);
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            /* U^2 = u u^T - |u|^2 I */
            T[3 * i + j] = 2 * s * (J[3 * i + j] + u[i] * u[j] - (i == j ? uu : 0));
            J[3 * i + j] = h * s * (J[3 * i + j] + (i == j ? 1 : 0));
        }
    }
}

/* >>dense */

ECP_DEF int ecp_lu_factor(int n, ecp_real *A, int ld, int *piv)
{
    int i, j, k;
    for (k = 0; k < n; k++) {
        int p = k;
        for (i = k + 1; i < n; i++) {
            if (ecp_i_abs(A[i * ld + k]) > ecp_i_abs(A[p * ld + k])) p = i;
        }
        piv[k] = p;
        if (A[p * ld + k] == 0) return k + 1;
        for (j = 0; p != k && j < n; j++) {
            ecp_real t = A[p * ld + j];
            A[p * ld + j] = A[k * ld + j];
            A[k * ld + j] = t;
        }
        for (i = k + 1; i < n; i++) {
            ecp_real factor = A[i * ld + k] /= A[k * ld + k];
            for (j = k + 1; j < n; j++) A[i * ld + j] -= factor * A[k * ld + j];
        }
    }
    return 0;
}

ECP_DEF void ecp_lu_solve(int n, const ecp_real *A, int ld, const int *piv, ecp_real *b)
{
    int i, j;
    for (i = 0; i < n; i++) {
        ecp_real t = b[piv[i]];
        b[piv[i]] = b[i];
        b[i] = t;
    }
    for (i = 0; i < n; i++) {
        for (j = 0; j < i; j++) b[i] -= A[i * ld + j] * b[j];
    }
    for (i = n - 1; i >= 0; i--) {
        for (j = i + 1; j < n; j++) b[i] -= A[i * ld + j] * b[j];
        b[i] /= A[i * ld + i];
    }
}

ECP_DEF int ecp_chol_factor(int n, ecp_real *A, int ld)
{
    int i, j, k;
    for (j = 0; j < n; j++) {
        ecp_real d = A[j * ld + j];
        for (k = 0; k < j; k++) d -= A[j * ld + k] * A[j * ld + k];
        if (!(d > 0)) return j + 1;
        d = ecp_i_sqrt(d);
        A[j * ld + j] = d;
        for (i = j + 1; i < n; i++) {
            ecp_real s = A[i * ld + j];
            for (k = 0; k < j; k++) s -= A[i * ld + k] * A[j * ld + k];
            A[i * ld + j] = s / d;
        }
    }
    return 0;
}

ECP_DEF void ecp_chol_solve(int n, const ecp_real *A, int ld, ecp_real *b)
{
    int i, j;
    for (i = 0; i < n; i++) {
        for (j = 0; j < i; j++) b[i] -= A[i * ld + j] * b[j];
        b[i] /= A[i * ld + i];
    }
    for (i = n - 1; i >= 0; i--) {
        for (j = i + 1; j < n; j++) b[i] -= A[j * ld + i] * b[j];
        b[i] /= A[i * ld + i];
    }
}

/* the largest of |row| */
static ecp_real ecp_i_row_size(int n, const ecp_real *row)
{
    ecp_real size = 0;
    int j;
    for (j = 0; j < n; j++) size = ecp_i_max(size, ecp_i_abs(row[j]));
    return size;
}

static void ecp_i_note_longest(ecp_real size, int j, ecp_real *most, int *longest)
{
    if (!(size > *most)) return;
    *most = size;
    *longest = j;
}

/* The norm of the longest of the columns k to n of A from row k to m, and which it is (k if all are zero): by
   squares, and where one that counts would over- or underflow once more in units of the largest entry. */
static ecp_real ecp_i_longest_column(int k, int m, int n, const ecp_real *A, int ld, int *longest)
{
    const ecp_real low = ECP_I_SMALLEST / (ECP_I_EPSILON * ECP_I_EPSILON);
    ecp_real most = 0, big = ECP_I_SMALLEST, unit = 1;
    int i, j, pass;
    for (pass = 0; pass < 2 && !(most > low && most < 1 / low); pass++) {
        for (i = k; pass > 0 && i < m; i++)
            big = ecp_i_max(big, ecp_i_row_size(n - k, A + i * ld + k));
        if (pass > 0) unit = 1 / ecp_i_power_of_two(big);
        most = 0;
        for (j = k; ECP_I_FAST && j + 3 < n; j += 4) {
            ecp_real a = 0, b = 0, c = 0, d = 0;
            for (i = k; i < m; i++) {
                const ecp_real *row = A + i * ld + j;
                a += row[0] * unit * (row[0] * unit);
                b += row[1] * unit * (row[1] * unit);
                c += row[2] * unit * (row[2] * unit);
                d += row[3] * unit * (row[3] * unit);
            }
            ecp_i_note_longest(a, j, &most, longest);
            ecp_i_note_longest(b, j + 1, &most, longest);
            ecp_i_note_longest(c, j + 2, &most, longest);
            ecp_i_note_longest(d, j + 3, &most, longest);
        }
        for (; j < n; j++) {
            ecp_real sum = 0;
            for (i = k; i < m; i++) sum += A[i * ld + j] * unit * (A[i * ld + j] * unit);
            ecp_i_note_longest(sum, j, &most, longest);
        }
    }
    return ecp_i_sqrt(most) / unit;
}

/* b -= tau v (v.b), v = (1, A(k+1:m, k)), on b(k:m) with the stride of a column or a vector */
static void ecp_i_reflect(int k, int m, const ecp_real *A, int ld, ecp_real tau, ecp_real *b,
                          int stride)
{
    ecp_real dot = b[k * stride];
    int i;
    for (i = k + 1; i < m; i++) dot += A[i * ld + k] * b[i * stride];
    dot *= tau;
    b[k * stride] -= dot;
    for (i = k + 1; i < m; i++) b[i * stride] -= dot * A[i * ld + k];
}

/* the same on columns k + 1 to n of A itself, four at a time */
static void ecp_i_reflect_columns(int k, int m, int n, ecp_real *A, int ld, ecp_real tau)
{
    int i, j;
    for (j = k + 1; ECP_I_FAST && j + 3 < n; j += 4) {
        ecp_real *b = A + k * ld + j, d0 = b[0], d1 = b[1], d2 = b[2], d3 = b[3];
        for (i = k + 1; i < m; i++) {
            const ecp_real v = A[i * ld + k], *row = A + i * ld + j;
            d0 += v * row[0];
            d1 += v * row[1];
            d2 += v * row[2];
            d3 += v * row[3];
        }
        d0 *= tau;
        d1 *= tau;
        d2 *= tau;
        d3 *= tau;
        b[0] -= d0;
        b[1] -= d1;
        b[2] -= d2;
        b[3] -= d3;
        for (i = k + 1; i < m; i++) {
            const ecp_real v = A[i * ld + k];
            b = A + i * ld + j;
            b[0] -= d0 * v;
            b[1] -= d1 * v;
            b[2] -= d2 * v;
            b[3] -= d3 * v;
        }
    }
    for (; j < n; j++) ecp_i_reflect(k, m, A, ld, tau, A + j, ld);
}

/* exchanges two rows or columns of n entries, each `stride` behind the one before */
static void ecp_i_exchange(int n, ecp_real *a, ecp_real *b, int stride)
{
    int i;
    for (i = 0; a != b && i < n; i++) {
        ecp_real t = a[stride * i];
        a[stride * i] = b[stride * i];
        b[stride * i] = t;
    }
}

static void ecp_i_exchange_ints(int *x, int a, int b)
{
    int t = x[a];
    x[a] = x[b];
    x[b] = t;
}

/* QR with column pivoting of the first n columns, applied to the others up to `all`; columns are
   zero when they are no longer than the tolerance times the first one, or than the floor */
static int ecp_i_qr(int m, int n, int all, ecp_real *A, int ld, ecp_real *tau, int *piv,
                    ecp_real tolerance, ecp_real floor)
{
    int steps = m < n ? m : n, i, j, k;
    ecp_real first = 0;
    for (j = 0; j < n; j++) piv[j] = j;
    for (k = 0; k < steps; k++) {
        int p = k;
        ecp_real best = ecp_i_longest_column(k, m, n, A, ld, &p), alpha, beta;
        if (k == 0) first = best;
        if (!(best > ecp_i_max(tolerance * first, floor))) return k;
        ecp_i_exchange(m, A + k, A + p, ld);
        ecp_i_exchange_ints(piv, k, p);
        alpha = A[k * ld + k];
        beta = alpha > 0 ? -best : best;
        tau[k] = (beta - alpha) / beta;
        for (i = k + 1; i < m; i++) A[i * ld + k] /= alpha - beta;
        ecp_i_reflect_columns(k, m, all, A, ld, tau[k]);
        A[k * ld + k] = beta;
    }
    return steps;
}

/* row -= factor * pivot, four at a time */
static void ecp_i_subtract_row(int n, ecp_real factor, const ecp_real *pivot, ecp_real *row)
{
    int j;
    for (j = 0; ECP_I_FAST && j + 3 < n; j += 4) {
        ecp_real a = row[j] - factor * pivot[j], b = row[j + 1] - factor * pivot[j + 1];
        ecp_real c = row[j + 2] - factor * pivot[j + 2], d = row[j + 3] - factor * pivot[j + 3];
        row[j] = a;
        row[j + 1] = b;
        row[j + 2] = c;
        row[j + 3] = d;
    }
    for (; j < n; j++) row[j] -= factor * pivot[j];
}

/* row -= factor[k] times row k of A for k < count, one after the other; four columns at a time, so that
   the row is read and written once */
static void ecp_i_subtract_rows(int n, int count, const ecp_real *factor, const ecp_real *A, int ld,
                                ecp_real *row)
{
    int j, k;
    for (j = 0; ECP_I_FAST && j + 3 < n; j += 4) {
        ecp_real a = row[j], b = row[j + 1], c = row[j + 2], d = row[j + 3];
        for (k = 0; k < count; k++) {
            const ecp_real *pivot = A + ld * k + j;
            a -= factor[k] * pivot[0];
            b -= factor[k] * pivot[1];
            c -= factor[k] * pivot[2];
            d -= factor[k] * pivot[3];
        }
        row[j] = a;
        row[j + 1] = b;
        row[j + 2] = c;
        row[j + 3] = d;
    }
    for (; j < n; j++) {
        ecp_real a = row[j];
        for (k = 0; k < count; k++) a -= factor[k] * A[ld * k + j];
        row[j] = a;
    }
}

/* rows of [R1 R2], R1 upper triangular, to [1 R1^-1 R2] */
static void ecp_i_solve_rows(int rank, int all, ecp_real *A, int ld)
{
    int i, j, k;
    for (i = rank - 1; i >= 0; i--) {
        ecp_real *row = A + ld * i;
        for (k = i + 1; k < rank; k++) {
            ecp_i_subtract_row(all - rank, row[k], A + ld * k + rank, row + rank);
        }
        for (j = rank; j < all; j++) row[j] /= row[i];
    }
}

ECP_DEF int ecp_qr_factor(int m, int n, ecp_real *A, int ld, ecp_real *tau, int *piv,
                          ecp_real tolerance)
{
    return ecp_i_qr(m, n, n, A, ld, tau, piv, tolerance, 0);
}

ECP_DEF void ecp_qr_apply_qt(int m, int rank, const ecp_real *A, int ld, const ecp_real *tau,
                             ecp_real *b)
{
    int k;
    for (k = 0; k < rank; k++) ecp_i_reflect(k, m, A, ld, tau[k], b, 1);
}

ECP_DEF void ecp_qr_apply_q(int m, int rank, const ecp_real *A, int ld, const ecp_real *tau,
                            ecp_real *b)
{
    int k;
    for (k = rank - 1; k >= 0; k--) ecp_i_reflect(k, m, A, ld, tau[k], b, 1);
}

/* A P = Q [R S; 0 0]; the shortest solution lies in the range of [R S]^T = Q2 R2:
   x = P Q2 R2^-T (Q^T b)(1:rank) */
ECP_DEF int ecp_least_squares(int m, int n, ecp_real *A, int ld, ecp_real *b, ecp_real *x,
                              ecp_real *work, int *iwork, ecp_real tolerance)
{
    ecp_real *T = work, *tau = work + n * n, *tau2 = tau + n, *y = tau2 + n;
    int *piv = iwork, *piv2 = iwork + n;
    int rank = ecp_qr_factor(m, n, A, ld, tau, piv, tolerance), i, j;
    ecp_qr_apply_qt(m, rank, A, ld, tau, b);
    for (i = 0; i < n; i++) {
        for (j = 0; j < rank; j++) T[i * n + j] = i >= j ? A[j * ld + i] : ECP_R(0);
    }
    ecp_qr_factor(n, rank, T, n, tau2, piv2, 0);
    for (j = 0; j < n; j++) y[j] = 0;
    for (j = 0; j < rank; j++) {
        y[j] = b[piv2[j]];
        for (i = 0; i < j; i++) y[j] -= T[i * n + j] * y[i];
        y[j] /= T[j * n + j];
    }
    ecp_qr_apply_q(n, rank, T, n, tau2, y);
    for (j = 0; j < n; j++) x[piv[j]] = y[j];
    return rank;
}

ECP_DEF int ecp_eliminate(ecp_real *A, int ld, int all_rows, int all_cols, int rows, int cols,
                          int first, int mask, ecp_real tolerance, int *row_tag, int *col_tag,
                          int *row_order, int *col_order)
{
    int k = first, i, j;
    for (; k < rows && k < cols; k++) {
        ecp_real best = tolerance;
        int p = -1, q = -1;
        for (i = k; i < rows; i++) {
            const ecp_real *row = A + i * ld;
            if (!(row_tag[i] & mask)) continue;
            for (j = k; j < cols; j++) {
                ecp_real size = ecp_i_abs(row[j]);
                if (!(size > best) || !(col_tag[j] & mask)) continue;
                best = size;
                p = i;
                q = j;
            }
        }
        if (p < 0) break;
        ecp_i_exchange(all_cols, A + k * ld, A + p * ld, 1);
        ecp_i_exchange(all_rows, A + k, A + q, ld);
        ecp_i_exchange_ints(row_tag, k, p);
        if (row_order) ecp_i_exchange_ints(row_order, k, p);
        ecp_i_exchange_ints(col_tag, k, q);
        ecp_i_exchange_ints(col_order, k, q);
        for (i = k + 1; i < all_rows; i++) {
            ecp_real factor = A[i * ld + k];
            if (factor == 0) continue;
            factor /= A[k * ld + k];
            A[i * ld + k] = factor;
            ecp_i_subtract_row(all_cols - k - 1, factor, A + k * ld + k + 1, A + i * ld + k + 1);
        }
    }
    return k;
}

/* >>shapes ================================================================================ */

#define ECP_I_PI ECP_R(3.14159265358979323846)

/* a constant that follows the precision of ecp_real */
#define ECP_I_BY_PRECISION(single_value, double_value)                                             \
    ECP_R(sizeof(ecp_real) == sizeof(float) ? (single_value) : (double_value))

/* smallest radius of a frustum relative to its size. The curvature of the side goes up as its
   inverse and costs as many digits of the Hessian, so each precision gives up a third of its digits */
#define ECP_I_FRUSTUM_TIP ECP_I_BY_PRECISION(1e-3, 1e-5)

/* a side of a bounding box on which the shape does not end */
#define ECP_I_UNBOUNDED ECP_R(1e30)

/* polytopes; lengths are relative to `reach`, the largest distance of a vertex from the origin
     UNIT         how far a normal may be from unit length
     INSIDE       rounding of a vertex (some 10 eps) when it is tested against the other planes
     SAME         copies of a vertex in which more than three planes meet are this near: rounding
                  divided by the determinant of three normals, so well above INSIDE
     CROSSING     least sine of two normals whose line is looked at for a recession direction
     RECEDE       rounding of that direction, some eps / CROSSING
     MEETING      least determinant of three normals whose common point is looked at. Small, because
                  an ill-determined point is no harm: it is on its own planes to rounding, and
                  has to be inside the others
     TIE          rounding of n.v, and of the sine between n and a face, for support points
     CLOSED       part of the surface's area that its area vectors may leave open */
#define ECP_I_POLY_UNIT ECP_R(1e-6)
#define ECP_I_POLY_INSIDE ECP_I_BY_PRECISION(4e-6, 1e-12)
#define ECP_I_POLY_SAME ECP_I_BY_PRECISION(4e-5, 1e-10)
#define ECP_I_POLY_CROSSING ECP_I_BY_PRECISION(1e-3, 1e-7)
#define ECP_I_POLY_RECEDE ECP_I_BY_PRECISION(4e-4, 1e-8)
#define ECP_I_POLY_MEETING ECP_I_BY_PRECISION(1e-6, 1e-12)
#define ECP_I_POLY_TIE ECP_I_BY_PRECISION(1e-6, 2e-15)
#define ECP_I_POLY_CLOSED ECP_I_BY_PRECISION(1e-2, 1e-6)

/* out = diag(a, b, c) */
static void ecp_i_diagonal(ecp_real out[9], ecp_real a, ecp_real b, ecp_real c)
{
    out[0] = a;
    out[1] = out[2] = out[3] = ECP_R(0);
    out[4] = b;
    out[5] = out[6] = out[7] = ECP_R(0);
    out[8] = c;
}

/* the planes z = h and z = -h, which close cylinder and frustum */
static void ecp_i_caps_eval(ecp_real h, ecp_real z, ecp_real f[2], ecp_real *g)
{
    f[0] = z - h;
    f[1] = -z - h;
    if (g != NULL) {
        ecp_i_set3(ECP_R(0), ECP_R(0), ECP_R(1), g);
        ecp_i_set3(ECP_R(0), ECP_R(0), ECP_R(-1), g + 3);
    }
}

/* ---- half-space: f = n.x - c */

static void ecp_i_half_space_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    f[0] = ecp_i_dot(s->size, x) - s->size[3];
    if (g != NULL) {
        ecp_i_copy3(s->size, g);
    }
}

/* there is a farthest point along the normal only; any other direction gets the same point */
static void ecp_i_half_space_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                     ecp_real x[3])
{
    (void)n;
    (void)flat;
    ecp_i_copy3(s->centre, x);
}

static void ecp_i_half_space_mass(const ecp_shape *s, ecp_mass *out)
{
    out->mass = ECP_R(0);
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, ECP_R(0), ECP_R(0), ECP_R(0));
}

/* ---- sphere: f = (|x|^2 - r^2) / (2 r), grad f = x / r, Hess f = I / r */

static void ecp_i_sphere_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    const ecp_real r = s->size[0];

    /* |x|^2 - r^2 = (|x| - r) (|x| + r) loses no digits near the surface */
    const ecp_real d = ecp_i_norm(x);
    f[0] = (d - r) * (d + r) / (ECP_R(2) * r);
    if (g != NULL) {
        ecp_i_set3(x[0] / r, x[1] / r, x[2] / r, g);
    }
}

static void ecp_i_sphere_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                              ecp_real H[9])
{
    const ecp_real c = l[0] / s->size[0];
    (void)x;
    ecp_i_diagonal(H, c, c, c);
}

static void ecp_i_sphere_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                 ecp_real x[3])
{
    const ecp_real r = s->size[0];
    (void)flat;
    ecp_i_set3(r * n[0], r * n[1], r * n[2], x);
}

static void ecp_i_sphere_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real r = s->size[0];
    const ecp_real m = ECP_R(4) / ECP_R(3) * ECP_I_PI * r * r * r;
    const ecp_real j = ECP_R(0.4) * m * r * r;
    out->mass = m;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, j, j, j);
}

/* ---- ellipsoid

   (Q - 1) / (2 sqrt(P)) has a unit gradient on the surface and grows like a distance outside, but
   is infinite at the centre. The term max(0, 1 - Q)^2 mends that; it vanishes on the surface
   together with its gradient, and its jump in the second derivative meets the factor Q - 1 = 0.

   With y_k = x_k / a_k and e_k = a_min / a_k <= 1 everything but the last factor has no dimension:

     u = |y|^2 - 1,  t = min(0, u),  w = sum e_k^2 y_k^2 + t^2,  s = w^(-1/2)
     f = (a_min / 2) u s

   and, with derivatives taken in y (then d/dx_k = (1 / a_k) d/dy_k),

     u_k = 2 y_k,                      u_kl = 2 delta_kl
     w_k = 2 (e_k^2 + 2 t) y_k,        w_kl = 2 (e_k^2 + 2 t) delta_kl + [u < 0] 2 u_k u_l
     s_k = -1/2 s^3 w_k,               s_kl = 3/4 s^5 w_k w_l - 1/2 s^3 w_kl
     (u s)_k = u_k s + u s_k,          (u s)_kl = u_kl s + u_k s_l + s_k u_l + u s_kl */

typedef struct ecp_i_ellipsoid {
    ecp_real a_min, u, t, s;
    ecp_real e[3], u1[3], w1[3], s1[3];
} ecp_i_ellipsoid;

static void ecp_i_ellipsoid_terms(const ecp_shape *s, const ecp_real x[3], ecp_i_ellipsoid *o)
{
    const ecp_real *a = s->size;
    ecp_real y[3];
    ecp_real w;

    o->a_min = ecp_i_min(a[0], ecp_i_min(a[1], a[2]));
    for (int k = 0; k < 3; ++k) {
        y[k] = x[k] / a[k];
        o->e[k] = o->a_min / a[k];
    }
    o->u = ecp_i_dot(y, y) - ECP_R(1);
    o->t = ecp_i_min(ECP_R(0), o->u);

    /* w > 0: the sum vanishes at the centre only, and there t = -1 */
    w = o->t * o->t;
    for (int k = 0; k < 3; ++k) {
        w += (o->e[k] * y[k]) * (o->e[k] * y[k]);
    }
    o->s = ECP_R(1) / ecp_i_sqrt(w);
    for (int k = 0; k < 3; ++k) {
        o->u1[k] = ECP_R(2) * y[k];
        o->w1[k] = ECP_R(2) * (o->e[k] * o->e[k] + ECP_R(2) * o->t) * y[k];
        o->s1[k] = ECP_R(-0.5) * o->s * o->s * o->s * o->w1[k];
    }
}

static void ecp_i_ellipsoid_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    ecp_i_ellipsoid o;

    ecp_i_ellipsoid_terms(s, x, &o);
    f[0] = ECP_R(0.5) * o.a_min * o.u * o.s;
    if (g != NULL) {
        for (int k = 0; k < 3; ++k) {
            g[k] = ECP_R(0.5) * o.e[k] * (o.u1[k] * o.s + o.u * o.s1[k]);
        }
    }
}

static void ecp_i_ellipsoid_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                                 ecp_real H[9])
{
    ecp_i_ellipsoid o;

    /* one triangle and its mirror image, so that H is symmetric to the bit */
    ecp_i_ellipsoid_terms(s, x, &o);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) {
            const ecp_real delta = i == j ? ECP_R(2) : ECP_R(0);
            const ecp_real s3 = o.s * o.s * o.s;
            ecp_real w2 = (o.e[i] * o.e[i] + ECP_R(2) * o.t) * delta;
            ecp_real s2, us2;

            if (o.u < ECP_R(0)) {
                w2 += ECP_R(2) * o.u1[i] * o.u1[j];
            }
            s2 = ECP_R(0.75) * s3 * o.s * o.s * o.w1[i] * o.w1[j] - ECP_R(0.5) * s3 * w2;
            us2 = delta * o.s + o.u1[i] * o.s1[j] + o.s1[i] * o.u1[j] + o.u * s2;
            H[3 * i + j] = l[0] * o.e[i] * o.e[j] / (ECP_R(2) * o.a_min) * us2;
            H[3 * j + i] = H[3 * i + j];
        }
    }
}

/* x = A^2 n / |A n| with A = diag(a) */
static void ecp_i_ellipsoid_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                    ecp_real x[3])
{
    const ecp_real *a = s->size;
    ecp_real b[3], d;
    (void)flat;

    ecp_i_set3(a[0] * n[0], a[1] * n[1], a[2] * n[2], b);
    d = ecp_i_norm(b);
    for (int k = 0; k < 3; ++k) {
        x[k] = a[k] * (b[k] / d);
    }
}

static void ecp_i_ellipsoid_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real *a = s->size;
    const ecp_real m = ECP_R(4) / ECP_R(3) * ECP_I_PI * a[0] * a[1] * a[2];
    const ecp_real c = ECP_R(0.2) * m;
    out->mass = m;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, c * (a[1] * a[1] + a[2] * a[2]), c * (a[0] * a[0] + a[2] * a[2]),
                   c * (a[0] * a[0] + a[1] * a[1]));
}

/* ---- capsule: f = (|d|^2 - r^2) / (2 r), d = x - (nearest point of the segment) */

static void ecp_i_capsule_offset(const ecp_shape *s, const ecp_real x[3], ecp_real d[3])
{
    const ecp_real h = s->size[1];
    ecp_i_set3(x[0], x[1], x[2] - ecp_i_max(-h, ecp_i_min(h, x[2])), d);
}

static void ecp_i_capsule_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    const ecp_real r = s->size[0];
    ecp_real d[3], distance;

    ecp_i_capsule_offset(s, x, d);
    distance = ecp_i_norm(d);
    f[0] = (distance - r) * (distance + r) / (ECP_R(2) * r);
    if (g != NULL) {
        ecp_i_set3(d[0] / r, d[1] / r, d[2] / r, g);
    }
}

static void ecp_i_capsule_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                               ecp_real H[9])
{
    const ecp_real c = l[0] / s->size[0];
    ecp_i_diagonal(H, c, c, ecp_i_abs(x[2]) > s->size[1] ? c : ECP_R(0));
}

static void ecp_i_capsule_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                  ecp_real x[3])
{
    const ecp_real r = s->size[0], h = s->size[1];
    const ecp_real side = ecp_i_sqrt(n[0] * n[0] + n[1] * n[1]);

    /* the middle of a generator, where n is normal to one. A capsule of no length has none */
    if (h > ECP_R(0) && side > ECP_R(0) && ecp_i_abs(n[2]) <= flat) {
        ecp_i_set3(r * (n[0] / side), r * (n[1] / side), ECP_R(0), x);
        return;
    }
    ecp_i_set3(r * n[0], r * n[1], r * n[2] + (n[2] > ECP_R(0) ? h : -h), x);
}

/* a cylinder (c) and a ball (b) in two halves, each half moved outwards by h; the first moment of
   half a ball about its flat side is 3/8 of its mass times r, which gives the mixed term */
static void ecp_i_capsule_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real r = s->size[0], h = s->size[1];
    const ecp_real c = ECP_R(2) * ECP_I_PI * r * r * h;
    const ecp_real b = ECP_R(4) / ECP_R(3) * ECP_I_PI * r * r * r;
    const ecp_real across = c * (ECP_R(0.25) * r * r + h * h / ECP_R(3)) +
                            b * (ECP_R(0.4) * r * r + h * h + ECP_R(0.75) * h * r);
    const ecp_real along = (ECP_R(0.5) * c + ECP_R(0.4) * b) * r * r;
    out->mass = c + b;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, across, across, along);
}

/* ---- cylinder: f_0 = (x^2 + y^2 - r^2) / (2 r), and two caps */

static void ecp_i_cylinder_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    const ecp_real r = s->size[0];
    const ecp_real d = ecp_i_sqrt(x[0] * x[0] + x[1] * x[1]);

    f[0] = (d - r) * (d + r) / (ECP_R(2) * r);
    if (g != NULL) {
        ecp_i_set3(x[0] / r, x[1] / r, ECP_R(0), g);
    }
    ecp_i_caps_eval(s->size[1], x[2], f + 1, g != NULL ? g + 3 : NULL);
}

static void ecp_i_cylinder_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                                ecp_real H[9])
{
    const ecp_real c = l[0] / s->size[0];
    (void)x;
    ecp_i_diagonal(H, c, c, ECP_R(0));
}

static void ecp_i_cylinder_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                   ecp_real x[3])
{
    const ecp_real r = s->size[0], h = s->size[1];
    const ecp_real side = ecp_i_sqrt(n[0] * n[0] + n[1] * n[1]);
    const ecp_real end = n[2] > ECP_R(0) ? h : -h;

    /* a cap's centre */
    if (side <= flat) {
        ecp_i_set3(ECP_R(0), ECP_R(0), end, x);
        return;
    }

    /* the middle of a generator, or a point of a rim */
    ecp_i_set3(r * (n[0] / side), r * (n[1] / side), ecp_i_abs(n[2]) <= flat ? ECP_R(0) : end, x);
}

static void ecp_i_cylinder_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real r = s->size[0], h = s->size[1];
    const ecp_real m = ECP_R(2) * ECP_I_PI * r * r * h;
    const ecp_real across = m * (ECP_R(0.25) * r * r + h * h / ECP_R(3));
    out->mass = m;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, across, across, ECP_R(0.5) * m * r * r);
}

/* ---- frustum: f_0 = ((x^2 + y^2) / rho - rho) / (2 K), K = sqrt(1 + k^2), and two caps

   A quadratic over a linear function is convex while rho > 0, and on the surface, where
   x^2 + y^2 = rho^2, the gradient is (x / rho, y / rho, -k) / K. Beyond the narrow end rho would
   reach zero, so below half the smaller radius, r0, it goes on as

     rho = r0 (1/2 + 1 / g),  g = 2 + 4 d + 8 d^2,  d = (r0 - rho_linear) / r0 >= 0

   which joins with its first and second derivative (in d: -1 and 0), and stays above r0 / 2. */

/* rho[0..2] = rho(z), rho'(z), rho''(z) */
static void ecp_i_frustum_rho(const ecp_shape *s, ecp_real z, ecp_real rho[3])
{
    const ecp_real bottom = s->size[0], top = s->size[1], h = s->size[2];
    const ecp_real k = (top - bottom) / (ECP_R(2) * h);
    const ecp_real r0 = ECP_R(0.5) * ecp_i_min(bottom, top);
    ecp_real d, g, g1;

    ecp_i_set3(ECP_R(0.5) * (bottom + top) + k * z, k, ECP_R(0), rho);
    if (rho[0] >= r0) {
        return;
    }

    /* (1/g)' = -g' / g^2 and (1/g)'' = (2 (g'/g)^2 - g''/g) / g, with dd/dz = -k / r0. Written as
       ratios, so that g may overflow */
    d = (r0 - rho[0]) / r0;
    g = ECP_R(2) + ECP_R(4) * d + ECP_R(8) * d * d;
    g1 = (ECP_R(4) + ECP_R(16) * d) / g;
    ecp_i_set3(r0 * (ECP_R(0.5) + ECP_R(1) / g), k * (g1 / g),
               k * (k / r0) * ((ECP_R(2) * g1 * g1 - ECP_R(16) / g) / g), rho);
}

static void ecp_i_frustum_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    const ecp_real K = s->size[3];
    const ecp_real d = ecp_i_sqrt(x[0] * x[0] + x[1] * x[1]);
    ecp_real rho[3], q;

    /* f_0 = (q - 1) (q + 1) rho / (2 K) with q = d / rho; df_0/dz = -(q^2 + 1) rho' / (2 K) */
    ecp_i_frustum_rho(s, x[2], rho);
    q = d / rho[0];
    f[0] = (d - rho[0]) * (q + ECP_R(1)) / (ECP_R(2) * K);
    if (g != NULL) {
        ecp_i_set3(x[0] / (rho[0] * K), x[1] / (rho[0] * K),
                   -(q * q + ECP_R(1)) * rho[1] / (ECP_R(2) * K), g);
    }
    ecp_i_caps_eval(s->size[2], x[2], f + 1, g != NULL ? g + 3 : NULL);
}

static void ecp_i_frustum_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                               ecp_real H[9])
{
    ecp_real rho[3], c, px, py, q2;

    /* with p = (x, y) / rho: f_xx = 1 / (rho K), f_xz = -p rho' / (rho K),
       f_zz = (|p|^2 rho'^2 / rho - (|p|^2 + 1) rho'' / 2) / K */
    ecp_i_frustum_rho(s, x[2], rho);
    c = l[0] / (rho[0] * s->size[3]);
    px = x[0] / rho[0];
    py = x[1] / rho[0];
    q2 = px * px + py * py;
    ecp_i_diagonal(H, c, c,
                   c * (q2 * rho[1] * rho[1] - ECP_R(0.5) * (q2 + ECP_R(1)) * rho[2] * rho[0]));
    H[2] = H[6] = -c * px * rho[1];
    H[5] = H[7] = -c * py * rho[1];
}

static void ecp_i_frustum_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                  ecp_real x[3])
{
    const ecp_real bottom = s->size[0], top = s->size[1], h = s->size[2], K = s->size[3];
    const ecp_real side = ecp_i_sqrt(n[0] * n[0] + n[1] * n[1]);
    ecp_real slope, r, z;

    /* a cap's centre */
    if (side <= flat) {
        ecp_i_set3(ECP_R(0), ECP_R(0), n[2] > ECP_R(0) ? h : -h, x);
        return;
    }

    /* the sine between n and the side's normal is n's component along the generator, (k, 1) / K;
       the sign of that decides between the rims */
    slope = ((top - bottom) / (ECP_R(2) * h) * side + n[2]) / K;
    r = slope > ECP_R(0) ? top : bottom;
    z = slope > ECP_R(0) ? h : -h;
    if (ecp_i_abs(slope) <= flat) {
        r = ECP_R(0.5) * (bottom + top);
        z = ECP_R(0);
    }
    ecp_i_set3(r * (n[0] / side), r * (n[1] / side), z, x);
}

/* with a, b the radii at the ends, k h = (b - a) / 2 and the mean radius r:

     volume       int pi rho^2       = 2 pi h (a^2 + a b + b^2) / 3
     z of centre                     = h (b^2 - a^2) / (2 (a^2 + a b + b^2))
     about z      int pi rho^4 / 2   = pi h (a^4 + a^3 b + a^2 b^2 + a b^3 + b^4) / 5
     int z^2      int pi rho^2 z^2   = 2 pi h^3 (r^2 / 3 + (k h)^2 / 5) */
static void ecp_i_frustum_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real a = s->size[0], b = s->size[1], h = s->size[2];
    const ecp_real r = ECP_R(0.5) * (a + b), kh = ECP_R(0.5) * (b - a);
    const ecp_real aa = a * a, ab = a * b, bb = b * b;
    const ecp_real m = ECP_R(2) / ECP_R(3) * ECP_I_PI * h * (aa + ab + bb);
    const ecp_real quartic = aa * aa + aa * ab + ab * ab + ab * bb + bb * bb;
    const ecp_real along = ECP_R(0.2) * ECP_I_PI * h * quartic;
    const ecp_real zz = ECP_R(2) * ECP_I_PI * h * h * h * (r * r / ECP_R(3) + kh * kh / ECP_R(5));
    const ecp_real across = ECP_R(0.5) * along + zz - m * s->centre[2] * s->centre[2];
    out->mass = m;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, across, across, along);
}

/* ---- box: f_2k = x_k - a_k, f_2k+1 = -x_k - a_k */

static void ecp_i_box_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    for (int k = 0; k < 3; ++k) {
        f[2 * k] = x[k] - s->size[k];
        f[2 * k + 1] = -x[k] - s->size[k];
        if (g != NULL) {
            ecp_i_set3(ECP_R(0), ECP_R(0), ECP_R(0), g + 6 * k);
            ecp_i_set3(ECP_R(0), ECP_R(0), ECP_R(0), g + 6 * k + 3);
            g[6 * k + k] = ECP_R(1);
            g[6 * k + 3 + k] = ECP_R(-1);
        }
    }
}

static void ecp_i_box_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat, ecp_real x[3])
{
    for (int k = 0; k < 3; ++k) {
        x[k] = n[k] > ECP_R(0) ? s->size[k] : -s->size[k];
        if (ecp_i_abs(n[k]) <= flat) {
            x[k] = ECP_R(0);
        }
    }
}

static void ecp_i_box_mass(const ecp_shape *s, ecp_mass *out)
{
    const ecp_real *a = s->size;
    const ecp_real m = ECP_R(8) * a[0] * a[1] * a[2];
    out->mass = m;
    ecp_i_copy3(s->centre, out->centre);
    ecp_i_diagonal(out->inertia, m * (a[1] * a[1] + a[2] * a[2]) / ECP_R(3),
                   m * (a[0] * a[0] + a[2] * a[2]) / ECP_R(3),
                   m * (a[0] * a[0] + a[1] * a[1]) / ECP_R(3));
}

/* ---- polytope: f_i = n_i.x - c_i */

static ecp_real ecp_i_plane_height(const ecp_real plane[4], const ecp_real x[3])
{
    return ecp_i_dot(plane, x) - plane[3];
}

static void ecp_i_polytope_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    for (int i = 0; i < s->inequalities; ++i) {
        f[i] = ecp_i_plane_height(s->planes + 4 * i, x);
        if (g != NULL) {
            ecp_i_copy3(s->planes + 4 * i, g + 3 * i);
        }
    }
}

/* is vertex v on face i? */
static int ecp_i_polytope_on(const ecp_shape *s, int i, int v)
{
    const ecp_real height = ecp_i_plane_height(s->planes + 4 * i, s->vertices + 3 * v);
    return ecp_i_abs(height) <= ECP_I_POLY_SAME * s->size[0];
}

/* the mean of the vertices on face i; returns how many there are */
static int ecp_i_polytope_middle(const ecp_shape *s, int i, ecp_real mean[3])
{
    ecp_real sum[3] = {0, 0, 0};
    int number = 0;

    for (int v = 0; v < s->vertex_count; ++v) {
        if (ecp_i_polytope_on(s, i, v)) {
            const ecp_real *p = s->vertices + 3 * v;
            ecp_i_set3(sum[0] + p[0], sum[1] + p[1], sum[2] + p[2], sum);
            ++number;
        }
    }
    for (int k = 0; k < 3 && number > 0; ++k) {
        mean[k] = sum[k] / (ecp_real)number;
    }
    return number;
}

/* v is the farthest vertex. Of the faces at v, the one turned least from n, by a sine |n x n_i|; of
   the edges at v, the one that falls off least, by a sine n.(v - w) / |v - w|. No list of edges is
   needed: all other vertices are in the cone of the edges from v, in which an edge falls off least */
static void ecp_i_polytope_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                   ecp_real x[3])
{
    const ecp_real *v = s->vertices, *end = s->vertices;
    ecp_real least = ECP_R(1);
    int best = 0, face = -1, flat_enough = 0;

    for (int i = 1; i < s->vertex_count; ++i) {
        if (ecp_i_dot(n, s->vertices + 3 * i) > ecp_i_dot(n, v)) {
            v = s->vertices + 3 * i;
            best = i;
        }
    }

    /* a face */
    for (int i = 0; i < s->inequalities; ++i) {
        ecp_real across[3], sine;
        ecp_i_cross(n, s->planes + 4 * i, across);
        sine = ecp_i_norm(across);
        if (sine < least && ecp_i_dot(n, s->planes + 4 * i) > ECP_R(0) &&
            ecp_i_polytope_on(s, i, best)) {
            least = sine;
            face = i;
        }
    }
    if (face >= 0 && least <= flat + ECP_I_POLY_TIE) {
        (void)ecp_i_polytope_middle(s, face, x);
        return;
    }

    /* an edge, or v itself */
    least = ECP_R(2);
    for (int i = 0; i < s->vertex_count; ++i) {
        const ecp_real *w = s->vertices + 3 * i;
        const ecp_real d[3] = {v[0] - w[0], v[1] - w[1], v[2] - w[2]};
        const ecp_real fall = ecp_i_dot(n, d), length = ecp_i_norm(d);
        if (i != best && fall < least * length) {
            least = fall / length;
            flat_enough = fall <= flat * length + ECP_I_POLY_TIE * s->size[0];
            end = w;
        }
    }
    ecp_i_copy3(v, x);
    for (int k = 0; k < 3 && flat_enough; ++k) {
        x[k] = ECP_R(0.5) * (v[k] + end[k]);
    }
}

/* are all vertices of face i also vertices of face j? */
static int ecp_i_polytope_within(const ecp_shape *s, int i, int j)
{
    for (int v = 0; v < s->vertex_count; ++v) {
        if (ecp_i_polytope_on(s, i, v) && !ecp_i_polytope_on(s, j, v)) {
            return 0;
        }
    }
    return 1;
}

/* the mean of the vertices of face i; returns 0 if i is redundant: if it touches an edge or a
   vertex only, or repeats another face. Of planes with the same vertices the first counts */
static int ecp_i_polytope_face(const ecp_shape *s, int i, ecp_real mean[3])
{
    if (ecp_i_polytope_middle(s, i, mean) < 3) {
        return 0;
    }
    for (int j = 0; j < s->inequalities; ++j) {
        if (j != i && ecp_i_polytope_within(s, i, j) &&
            (j < i || !ecp_i_polytope_within(s, j, i))) {
            return 0;
        }
    }
    return 1;
}

/* two unit vectors a, b with a x b = n */
static void ecp_i_plane_axes(const ecp_real n[3], ecp_real a[3], ecp_real b[3])
{
    const ecp_real nx = ecp_i_abs(n[0]), ny = ecp_i_abs(n[1]), nz = ecp_i_abs(n[2]);
    ecp_real length;

    /* n x (the axis that n is farthest from) is at least sqrt(2/3) long */
    if (nx <= ny && nx <= nz) {
        ecp_i_set3(ECP_R(0), n[2], -n[1], a);
    } else if (ny <= nz) {
        ecp_i_set3(-n[2], ECP_R(0), n[0], a);
    } else {
        ecp_i_set3(n[1], -n[0], ECP_R(0), a);
    }
    length = ecp_i_norm(a);
    ecp_i_set3(a[0] / length, a[1] / length, a[2] / length, a);
    ecp_i_cross(n, a, b);
}

/* the direction of p - o in the plane of a and b as a number in [0, 4) that grows with the angle:
   the distance along the square |x| + |y| = 1 */
static ecp_real ecp_i_square_angle(const ecp_real p[3], const ecp_real o[3], const ecp_real a[3],
                                   const ecp_real b[3])
{
    ecp_real d[3], x, y, l;

    ecp_i_set3(p[0] - o[0], p[1] - o[1], p[2] - o[2], d);
    x = ecp_i_dot(d, a);
    y = ecp_i_dot(d, b);
    l = ecp_i_abs(x) + ecp_i_abs(y);
    if (l == ECP_R(0)) {
        return ECP_R(0);
    }
    return y >= ECP_R(0) ? ECP_R(1) - x / l : ECP_R(3) + x / l;
}

/* integrals over a polytope about the origin `o`: volume, int x, int x x^T (lower triangle), and
   the sums of all area vectors and of their lengths */
typedef struct ecp_i_integrals {
    ecp_real o[3];
    ecp_real volume, first[3], second[9];
    ecp_real open[3], area;
} ecp_i_integrals;

/* adds the tetrahedron (o, p, q, r). About o, with volume V = p.(q x r) / 6 and t = p + q + r,
   int x = V t / 4 and int x x^T = V (p p^T + q q^T + r r^T + t t^T) / 20. (q x r of a needle is large, and
   p.(q x r) what cancels; the triangle's area vector, which has the same product with p, is small. Of a
   triangle as long as p, at a tip D away, it is still D^2 eps.) */
static void ecp_i_integrals_add(ecp_i_integrals *sum, const ecp_real p0[3], const ecp_real q0[3],
                                const ecp_real r0[3])
{
    ecp_real p[3], q[3], r[3], pq[3], pr[3], area[3], t[3], volume;

    for (int k = 0; k < 3; ++k) {
        p[k] = p0[k] - sum->o[k];
        q[k] = q0[k] - sum->o[k];
        r[k] = r0[k] - sum->o[k];
        pq[k] = q[k] - p[k];
        pr[k] = r[k] - p[k];
        t[k] = p[k] + q[k] + r[k];
    }
    ecp_i_cross(pq, pr, area);
    volume = ecp_i_dot(p, area) / ECP_R(6);
    sum->volume += volume;
    for (int i = 0; i < 3; ++i) {
        sum->first[i] += volume * t[i] / ECP_R(4);
        for (int j = 0; j <= i; ++j) {
            sum->second[3 * i + j] +=
                volume / ECP_R(20) * (p[i] * p[j] + q[i] * q[j] + r[i] * r[j] + t[i] * t[j]);
        }
    }
    for (int k = 0; k < 3; ++k) {
        sum->open[k] += ECP_R(0.5) * area[k];
    }
    sum->area += ECP_R(0.5) * ecp_i_norm(area);
}

/* the divergence theorem: the polytope is the sum of the tetrahedra between an inner point and
   triangles of its surface. A face is split from its middle, going round its vertices by angle;
   that needs no list of them, and ends whatever the rounding, because the angle only grows */
static void ecp_i_polytope_integrate(const ecp_shape *s, ecp_i_integrals *sum)
{
    const ecp_i_integrals zero = {{0}, 0, {0}, {0}, {0}, 0};

    /* the inner point is the mean of the vertices */
    *sum = zero;
    for (int v = 0; v < s->vertex_count; ++v) {
        for (int k = 0; k < 3; ++k) {
            sum->o[k] += s->vertices[3 * v + k] / (ecp_real)s->vertex_count;
        }
    }
    for (int i = 0; i < s->inequalities; ++i) {
        ecp_real middle[3], a[3], b[3], angle = ECP_R(-1);
        const ecp_real *first = NULL, *last = NULL;

        if (!ecp_i_polytope_face(s, i, middle)) {
            continue;
        }
        ecp_i_plane_axes(s->planes + 4 * i, a, b);
        for (;;) {
            /* the next vertex in angle, if there is one */
            const ecp_real *next = NULL;
            ecp_real least = ECP_R(5);
            for (int v = 0; v < s->vertex_count; ++v) {
                if (ecp_i_polytope_on(s, i, v)) {
                    const ecp_real *p = s->vertices + 3 * v;
                    const ecp_real at = ecp_i_square_angle(p, middle, a, b);
                    if (at > angle && at < least) {
                        least = at;
                        next = p;
                    }
                }
            }
            if (next == NULL) {
                break;
            }
            if (last != NULL) {
                ecp_i_integrals_add(sum, middle, last, next);
            } else {
                first = next;
            }
            last = next;
            angle = least;
        }
        ecp_i_integrals_add(sum, middle, last, first);
    }
}

/* from the integrals: centre = o + c, c = int x / V; about the centre, C = int x x^T - V c c^T, and
   the inertia is trace(C) I - C */
static void ecp_i_integrals_mass(const ecp_i_integrals *sum, ecp_mass *out)
{
    ecp_real c[3], trace = ECP_R(0);

    out->mass = sum->volume;
    for (int k = 0; k < 3; ++k) {
        c[k] = sum->first[k] / sum->volume;
        out->centre[k] = sum->o[k] + c[k];
        trace += sum->second[4 * k] - sum->volume * c[k] * c[k];
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) {
            out->inertia[3 * i + j] =
                (i == j ? trace : ECP_R(0)) - (sum->second[3 * i + j] - sum->volume * c[i] * c[j]);
            out->inertia[3 * j + i] = out->inertia[3 * i + j];
        }
    }
}

static void ecp_i_polytope_mass(const ecp_shape *s, ecp_mass *out)
{
    ecp_i_integrals sum;
    ecp_i_polytope_integrate(s, &sum);
    ecp_i_integrals_mass(&sum, out);
}

/* ---- classes */

static const ecp_shape_class ecp_i_half_space_class = {ecp_i_half_space_eval, NULL,
                                                       ecp_i_half_space_support, NULL};
static const ecp_shape_class ecp_i_sphere_class = {ecp_i_sphere_eval, ecp_i_sphere_hess,
                                                   ecp_i_sphere_support, ecp_i_sphere_mass};
static const ecp_shape_class ecp_i_ellipsoid_class = {
    ecp_i_ellipsoid_eval, ecp_i_ellipsoid_hess, ecp_i_ellipsoid_support, ecp_i_ellipsoid_mass};
static const ecp_shape_class ecp_i_capsule_class = {ecp_i_capsule_eval, ecp_i_capsule_hess,
                                                    ecp_i_capsule_support, ecp_i_capsule_mass};
static const ecp_shape_class ecp_i_cylinder_class = {ecp_i_cylinder_eval, ecp_i_cylinder_hess,
                                                     ecp_i_cylinder_support, ecp_i_cylinder_mass};
static const ecp_shape_class ecp_i_frustum_class = {ecp_i_frustum_eval, ecp_i_frustum_hess,
                                                    ecp_i_frustum_support, ecp_i_frustum_mass};
static const ecp_shape_class ecp_i_box_class = {ecp_i_box_eval, NULL, ecp_i_box_support,
                                                ecp_i_box_mass};
static const ecp_shape_class ecp_i_polytope_class = {ecp_i_polytope_eval, NULL,
                                                     ecp_i_polytope_support, ecp_i_polytope_mass};

/* ---- constructors */

/* sizes of which the squares are numbers still, and not nothing */
static int ecp_i_measurable(ecp_real radius)
{
    ecp_real square = radius * radius;
    return square > 0 && ecp_i_finite(square);
}

static ecp_status ecp_i_check_sizes(const ecp_real *size, int count)
{
    if (!ecp_i_all_finite(count, size)) {
        return ECP_NOT_FINITE;
    }
    for (int i = 0; i < count; ++i) {
        if (size[i] <= ECP_R(0) || !ecp_i_measurable(size[i])) {
            return ECP_BAD_SIZE;
        }
    }
    return ECP_OK;
}

/* fills *s for a shape that is centred at the origin; `size` has four entries */
static void ecp_i_shape_set(ecp_shape *s, const ecp_shape_class *cls, ecp_shape_kind kind,
                            int inequalities, const ecp_real size[4], ecp_real radius)
{
    ECPSIM_MEMSET(s, 0, sizeof *s); /* padding as well: worlds are compared as bytes */
    s->cls = cls;
    s->kind = kind;
    s->inequalities = inequalities;
    for (int k = 0; k < 4; ++k) {
        s->size[k] = size[k];
    }
    s->radius = radius;
}

ECP_DEF ecp_status ecp_shape_half_space(ecp_shape *s, const ecp_real normal[3], ecp_real offset)
{
    ecp_real size[4], largest, length;

    if (s == NULL || normal == NULL) {
        return ECP_BAD_POINTER;
    }
    if (!ecp_i_all_finite(3, normal) || !ecp_i_finite(offset)) {
        return ECP_NOT_FINITE;
    }

    /* dividing by the largest component first keeps the squares from under- or overflowing */
    largest = ecp_i_max(ecp_i_abs(normal[0]), ecp_i_abs(normal[1]));
    largest = ecp_i_max(largest, ecp_i_abs(normal[2]));
    if (largest == ECP_R(0)) {
        return ECP_BAD_SIZE;
    }
    ecp_i_set3(normal[0] / largest, normal[1] / largest, normal[2] / largest, size);
    length = ecp_i_norm(size);
    ecp_i_set3(size[0] / length, size[1] / length, size[2] / length, size);
    size[3] = offset / largest / length;
    if (!ecp_i_finite(size[3])) {
        return ECP_BAD_SIZE;
    }

    ecp_i_shape_set(s, &ecp_i_half_space_class, ECP_HALF_SPACE, 1, size, ECP_R(-1));
    ecp_i_set3(size[3] * size[0], size[3] * size[1], size[3] * size[2], s->centre);
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_sphere(ecp_shape *s, ecp_real radius)
{
    const ecp_real size[4] = {radius, 0, 0, 0};
    ecp_status status;

    if (s == NULL) {
        return ECP_BAD_POINTER;
    }
    status = ecp_i_check_sizes(size, 1);
    if (status == ECP_OK) {
        ecp_i_shape_set(s, &ecp_i_sphere_class, ECP_SPHERE, 1, size, radius);
    }
    return status;
}

ECP_DEF ecp_status ecp_shape_ellipsoid(ecp_shape *s, const ecp_real radii[3])
{
    ecp_real size[4] = {0, 0, 0, 0};
    ecp_status status;

    if (s == NULL || radii == NULL) {
        return ECP_BAD_POINTER;
    }
    ecp_i_copy3(radii, size);
    status = ecp_i_check_sizes(size, 3);
    if (status == ECP_OK) {
        ecp_i_shape_set(s, &ecp_i_ellipsoid_class, ECP_ELLIPSOID, 1, size,
                        ecp_i_max(size[0], ecp_i_max(size[1], size[2])));
    }
    return status;
}

ECP_DEF ecp_status ecp_shape_capsule(ecp_shape *s, ecp_real radius, ecp_real half_length)
{
    const ecp_real size[4] = {radius, half_length, 0, 0};

    if (s == NULL) {
        return ECP_BAD_POINTER;
    }
    if (!ecp_i_all_finite(2, size)) {
        return ECP_NOT_FINITE;
    }
    if (radius <= ECP_R(0) || half_length < ECP_R(0) || !ecp_i_measurable(radius) ||
        !ecp_i_measurable(radius + half_length)) {
        return ECP_BAD_SIZE;
    }
    ecp_i_shape_set(s, &ecp_i_capsule_class, ECP_CAPSULE, 1, size, radius + half_length);
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_cylinder(ecp_shape *s, ecp_real radius, ecp_real half_height)
{
    const ecp_real size[4] = {radius, half_height, 0, 0};
    ecp_real reach;
    ecp_status status;

    if (s == NULL) {
        return ECP_BAD_POINTER;
    }
    status = ecp_i_check_sizes(size, 2);
    if (status != ECP_OK) return status;
    reach = ecp_i_sqrt(radius * radius + half_height * half_height);
    if (!ecp_i_measurable(reach)) return ECP_BAD_SIZE;
    ecp_i_shape_set(s, &ecp_i_cylinder_class, ECP_CYLINDER, 3, size, reach);
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_frustum(ecp_shape *s, ecp_real bottom_radius, ecp_real top_radius,
                                     ecp_real half_height)
{
    ecp_real size[4] = {bottom_radius, top_radius, half_height, 0};
    ecp_real a, b, h, k, wide, tip, z;

    if (s == NULL) {
        return ECP_BAD_POINTER;
    }
    if (!ecp_i_all_finite(3, size)) {
        return ECP_NOT_FINITE;
    }
    wide = ecp_i_max(bottom_radius, top_radius);
    if (ecp_i_min(bottom_radius, top_radius) < ECP_R(0) || wide <= ECP_R(0) ||
        half_height <= ECP_R(0) || !ecp_i_measurable(half_height) ||
        !ecp_i_measurable(ECP_R(4) * (wide + half_height)) ||
        !ecp_i_measurable(ECP_I_FRUSTUM_TIP * wide)) {
        return ECP_BAD_SIZE;
    }

    /* raise a tip; a needle, thinner than the tip would be, becomes a cylinder */
    tip = ecp_i_min(wide, ECP_I_FRUSTUM_TIP * ecp_i_max(wide, half_height));
    a = size[0] = ecp_i_max(bottom_radius, tip);
    b = size[1] = ecp_i_max(top_radius, tip);
    h = half_height;
    k = (b - a) / (ECP_R(2) * h);
    size[3] = ecp_i_sqrt(ECP_R(1) + k * k);
    if (!ecp_i_finite(size[3])) {
        return ECP_BAD_SIZE;
    }

    /* the centroid, and the farther of the two rims from it */
    z = h * ((b - a) * (b + a) / (ECP_R(2) * (a * a + a * b + b * b)));
    ecp_i_shape_set(s, &ecp_i_frustum_class, ECP_FRUSTUM, 3, size,
                    ecp_i_sqrt(ecp_i_max(a * a + (h + z) * (h + z), b * b + (h - z) * (h - z))));
    s->centre[2] = z;
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_box(ecp_shape *s, const ecp_real half[3])
{
    ecp_real size[4] = {0, 0, 0, 0};
    ecp_status status;

    if (s == NULL || half == NULL) {
        return ECP_BAD_POINTER;
    }
    ecp_i_copy3(half, size);
    status = ecp_i_check_sizes(size, 3);
    if (status != ECP_OK) return status;
    if (!ecp_i_measurable(ecp_i_norm(size))) return ECP_BAD_SIZE;
    ecp_i_shape_set(s, &ecp_i_box_class, ECP_BOX, 6, size, ecp_i_norm(size));
    return ECP_OK;
}

/* is a direction d != 0 with n_i.d <= 0 for all i? If there is one, there is one along the line of
   two planes: the cone of such d has an extreme ray, or holds the line that all planes share */
static int ecp_i_polytope_recedes(const ecp_real *planes, int count)
{
    int crossed = 0;

    for (int i = 0; i < count; ++i) {
        for (int j = i + 1; j < count; ++j) {
            ecp_real d[3], length, up = ECP_R(-2), down = ECP_R(-2);

            ecp_i_cross(planes + 4 * i, planes + 4 * j, d);
            length = ecp_i_norm(d);
            if (length <= ECP_I_POLY_CROSSING) {
                continue;
            }
            crossed = 1;
            for (int k = 0; k < count; ++k) {
                const ecp_real rise = ecp_i_dot(planes + 4 * k, d) / length;
                up = ecp_i_max(up, rise);
                down = ecp_i_max(down, -rise);
            }
            if (ecp_i_min(up, down) <= ECP_I_POLY_RECEDE) {
                return 1;
            }
        }
    }

    /* all planes parallel */
    return !crossed;
}

/* the point that three planes share, if they do and it is inside all the others to rounding at `reach`,
   or at its own distance from the origin if that is larger.
   x = (c_0 n_1 x n_2 + c_1 n_2 x n_0 + c_2 n_0 x n_1) / (n_0.n_1 x n_2), and once more for what
   rounding has left of the three heights */
static int ecp_i_polytope_corner(const ecp_real *planes, int count, const int triple[3],
                                 ecp_real reach, ecp_real x[3])
{
    const ecp_real *p[3];
    ecp_real dual[3][3], det;

    for (int k = 0; k < 3; ++k) {
        p[k] = planes + 4 * triple[k];
    }
    for (int k = 0; k < 3; ++k) {
        ecp_i_cross(p[(k + 1) % 3], p[(k + 2) % 3], dual[k]);
    }
    det = ecp_i_dot(p[0], dual[0]);
    if (ecp_i_abs(det) <= ECP_I_POLY_MEETING) {
        return 0;
    }
    ecp_i_set3(ECP_R(0), ECP_R(0), ECP_R(0), x);
    for (int round = 0; round < 2; ++round) {
        ecp_real height[3];
        for (int k = 0; k < 3; ++k) {
            height[k] = ecp_i_plane_height(p[k], x);
        }
        for (int k = 0; k < 3; ++k) {
            x[k] -=
                (height[0] * dual[0][k] + height[1] * dual[1][k] + height[2] * dual[2][k]) / det;
        }
    }
    reach = ecp_i_max(reach, ecp_i_norm(x));
    for (int i = 0; i < count; ++i) {
        if (!(ecp_i_plane_height(planes + 4 * i, x) <= ECP_I_POLY_INSIDE * reach)) {
            return 0;
        }
    }
    return 1;
}

/* moves on to the next triple i < j < k < count; returns 0 after the last */
static int ecp_i_next_triple(int triple[3], int count)
{
    if (++triple[2] < count) {
        return 1;
    }
    if (++triple[1] < count - 1) {
        triple[2] = triple[1] + 1;
        return 1;
    }
    if (++triple[0] < count - 2) {
        triple[1] = triple[0] + 1;
        triple[2] = triple[0] + 2;
        return 1;
    }
    return 0;
}

/* The largest distance of a vertex from the origin; negative if there is no vertex. (Offsets say little
   of it: a needle's are as small as it is thin, and that of a redundant plane may be anything.) */
static ecp_real ecp_i_polytope_reach(const ecp_real *planes, int count)
{
    int triple[3] = {0, 1, 1};
    ecp_real x[3], reach = ECP_R(-1);

    while (ecp_i_next_triple(triple, count)) {
        if (ecp_i_polytope_corner(planes, count, triple, ECP_R(0), x)) {
            reach = ecp_i_max(reach, ecp_i_norm(x));
        }
    }
    return reach;
}

/* lists the vertices, each once */
static ecp_status ecp_i_polytope_vertices(const ecp_real *planes, int count, ecp_real reach,
                                          ecp_real *vertices, int capacity, int *number)
{
    int triple[3] = {0, 1, 1};
    ecp_real x[3];

    *number = 0;
    while (ecp_i_next_triple(triple, count)) {
        int known = 0;
        if (!ecp_i_polytope_corner(planes, count, triple, reach, x)) {
            continue;
        }
        for (int v = 0; v < *number && !known; ++v) {
            ecp_real d[3];
            ecp_i_set3(x[0] - vertices[3 * v], x[1] - vertices[3 * v + 1],
                       x[2] - vertices[3 * v + 2], d);
            known = ecp_i_norm(d) <= ECP_I_POLY_SAME * reach;
        }
        if (known) {
            continue;
        }
        if (*number == capacity) {
            return ECP_CAPACITY;
        }
        ecp_i_copy3(x, vertices + 3 * *number);
        ++*number;
    }
    return ECP_OK;
}

/* does any plane hold all vertices? Without inner points, one of the inequalities is an equality
   on all of the polytope (Farkas) */
static int ecp_i_polytope_flat(const ecp_shape *s)
{
    for (int i = 0; i < s->inequalities; ++i) {
        int v = 0;
        while (v < s->vertex_count && ecp_i_polytope_on(s, i, v)) {
            ++v;
        }
        if (v == s->vertex_count) {
            return 1;
        }
    }
    return 0;
}

static ecp_status ecp_i_check_planes(const ecp_real *planes, int count)
{
    if (!ecp_i_all_finite(4 * count, planes)) {
        return ECP_NOT_FINITE;
    }
    for (int i = 0; i < count; ++i) {
        if (ecp_i_abs(ecp_i_norm(planes + 4 * i) - ECP_R(1)) > ECP_I_POLY_UNIT) {
            return ECP_BAD_SIZE;
        }
    }
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_polytope(ecp_shape *s, const ecp_real *planes, int count,
                                      ecp_real *vertices, int vertex_capacity)
{
    ecp_real size[4] = {0, 0, 0, 0};
    ecp_shape made;
    ecp_i_integrals sum;
    ecp_mass mass;
    ecp_status status;

    if (s == NULL || planes == NULL || vertices == NULL) {
        return ECP_BAD_POINTER;
    }
    if (count < 1 || vertex_capacity < 1) {
        return ECP_BAD_SIZE;
    }
    status = ecp_i_check_planes(planes, count);
    if (status != ECP_OK) {
        return status;
    }
    if (ecp_i_polytope_recedes(planes, count)) {
        return ECP_UNBOUNDED_POLYTOPE;
    }

    /* vertices; a single one at the origin has reach 0 */
    size[0] = ecp_i_polytope_reach(planes, count);
    if (!ecp_i_finite(size[0])) {
        return ECP_BAD_SIZE;
    }
    if (size[0] <= ECP_R(0)) {
        return ECP_EMPTY_POLYTOPE;
    }
    ecp_i_shape_set(&made, &ecp_i_polytope_class, ECP_POLYTOPE, count, size, ECP_R(0));
    made.planes = planes;
    made.vertices = vertices;
    status = ecp_i_polytope_vertices(planes, count, size[0], vertices, vertex_capacity,
                                     &made.vertex_count);
    if (status != ECP_OK) {
        return status;
    }
    if (ecp_i_polytope_flat(&made)) {
        return ECP_EMPTY_POLYTOPE;
    }

    /* faces: the area vectors of a closed surface add up to zero, so this tells whether they fit */
    ecp_i_polytope_integrate(&made, &sum);
    if (!(sum.volume > ECP_R(0)) || !(ecp_i_norm(sum.open) <= ECP_I_POLY_CLOSED * sum.area)) {
        return ECP_BAD_SIZE;
    }
    ecp_i_integrals_mass(&sum, &mass);
    ecp_i_copy3(mass.centre, made.centre);
    for (int v = 0; v < made.vertex_count; ++v) {
        ecp_real d[3];
        ecp_i_set3(vertices[3 * v] - mass.centre[0], vertices[3 * v + 1] - mass.centre[1],
                   vertices[3 * v + 2] - mass.centre[2], d);
        made.radius = ecp_i_max(made.radius, ecp_i_norm(d));
    }
    if (!ecp_i_all_finite(3, made.centre) || !ecp_i_measurable(made.radius)) {
        return ECP_BAD_SIZE;
    }
    ECPSIM_MEMCPY(s, &made, sizeof made);
    return ECP_OK;
}

/* by how much of its radius a class may err when it is tried: this is to find mistakes, not rounding */
#ifdef ECPSIM_FLOAT
#define ECP_I_SUPPORT_ERROR ECP_R(1e-4)
#else
#define ECP_I_SUPPORT_ERROR ECP_R(1e-6)
#endif

/* Are the support points along the axes within the radius, and each the farthest of them along its direction? */
static ecp_status ecp_i_try_support(const ecp_shape *s)
{
    ecp_real x[6][3], from[3], slack = ECP_I_SUPPORT_ERROR * (s->radius + ecp_i_norm(s->centre));
    int i, j;
    for (i = 0; i < 6; i++) {
        ecp_real n[3] = {0, 0, 0};
        n[i / 2] = i % 2 ? ECP_R(-1) : ECP_R(1);
        s->cls->support(s, n, 0, x[i]);
        if (!ecp_i_all_finite(3, x[i])) return ECP_NOT_FINITE;
        ecp_i_sub(x[i], s->centre, from);
        if (!(ecp_i_norm(from) <= s->radius + slack)) return ECP_BAD_SUPPORT;
    }
    for (i = 0; i < 6; i++) {
        for (j = 0; j < 6; j++) {
            ecp_real ahead = x[j][i / 2] - x[i][i / 2];
            if (!((i % 2 ? -ahead : ahead) <= slack)) return ECP_BAD_SUPPORT;
        }
    }
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_convex(ecp_shape *s, const ecp_shape_class *cls, int inequalities,
                                    const ecp_real centre[3], ecp_real radius, const void *user)
{
    const ecp_real size[4] = {0, 0, 0, 0};
    ecp_shape shape;
    ecp_status status;

    if (s == NULL || cls == NULL || centre == NULL || cls->eval == NULL || cls->support == NULL) {
        return ECP_BAD_POINTER;
    }
    if (!ecp_i_all_finite(3, centre) || !ecp_i_finite(radius)) {
        return ECP_NOT_FINITE;
    }
    if (inequalities < 1 || radius <= ECP_R(0) || !ecp_i_measurable(radius)) {
        return ECP_BAD_SIZE;
    }
    ecp_i_shape_set(&shape, cls, ECP_CONVEX, inequalities, size, radius);
    ecp_i_copy3(centre, shape.centre);
    shape.user = user;
    status = ecp_i_try_support(&shape);
    if (status == ECP_OK) *s = shape;
    return status;
}

/* ---- bounds and mass */

/* of all but half-spaces, whose support says nothing */
static void ecp_i_shape_bounds(const ecp_shape *s, ecp_real lo[3], ecp_real hi[3])
{
    for (int k = 0; k < 3; ++k) {
        ecp_real n[3] = {0, 0, 0}, x[3];

        n[k] = ECP_R(1);
        s->cls->support(s, n, ECP_R(0), x);
        hi[k] = x[k];
        n[k] = ECP_R(-1);
        s->cls->support(s, n, ECP_R(0), x);
        lo[k] = x[k];
    }
}

ECP_DEF void ecp_shape_bounds(const ecp_shape *s, ecp_real lo[3], ecp_real hi[3])
{
    ecp_i_shape_bounds(s, lo, hi);

    /* a half-space ends along its own normal only, and by no tilt however small */
    for (int k = 0; k < 3 && s->kind == ECP_HALF_SPACE; ++k) {
        const int tilted = ecp_i_abs(s->size[(k + 1) % 3]) + ecp_i_abs(s->size[(k + 2) % 3]) > 0;
        if (tilted || s->size[k] < 0) hi[k] = ECP_I_UNBOUNDED;
        if (tilted || s->size[k] > 0) lo[k] = -ECP_I_UNBOUNDED;
    }
}

ECP_DEF void ecp_shape_mass(const ecp_shape *s, ecp_real density, ecp_mass *out)
{
    if (s->cls->mass == NULL) {
        ecp_i_half_space_mass(s, out);
        return;
    }
    s->cls->mass(s, out);
    out->mass *= density;
    for (int k = 0; k < 9; ++k) {
        out->inertia[k] *= density;
    }
}

/* R = I + (2 / |q|^2) (w V + V V), V = the cross product matrix of (x, y, z) */
static void ecp_i_mass_rotation(const ecp_real rotation[4], ecp_real R[9])
{
    ecp_real q[4], w, x, y, z, c;
    ecp_i_quat_scaled(rotation, q);
    w = q[0];
    x = q[1];
    y = q[2];
    z = q[3];
    c = ECP_R(2) / (w * w + x * x + y * y + z * z);
    R[0] = ECP_R(1) - c * (y * y + z * z);
    R[1] = c * (x * y - w * z);
    R[2] = c * (x * z + w * y);
    R[3] = c * (x * y + w * z);
    R[4] = ECP_R(1) - c * (x * x + z * z);
    R[5] = c * (y * z - w * x);
    R[6] = c * (x * z - w * y);
    R[7] = c * (y * z + w * x);
    R[8] = ECP_R(1) - c * (x * x + y * y);
}

/* with m = m_1 + m_2 and d = c_2 - c_1: c = c_1 + (m_2 / m) d, and by the theorem of parallel axes
   I = I_1 + R I_2 R^T + (m_1 m_2 / m) (|d|^2 I - d d^T) */
ECP_DEF void ecp_mass_add(ecp_mass *total, const ecp_mass *part, const ecp_real position[3],
                          const ecp_real rotation[4])
{
    const ecp_real m1 = total->mass, m2 = part->mass, m = m1 + m2;
    ecp_mass sum = *total;
    ecp_real R[9], RI[9], d[3], share;

    if (m == ECP_R(0)) {
        return;
    }
    ecp_i_mass_rotation(rotation, R);
    share = m2 / m;
    for (int i = 0; i < 3; ++i) {
        d[i] = position[i] + ecp_i_dot(R + 3 * i, part->centre) - total->centre[i];
        sum.centre[i] += share * d[i];
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            RI[3 * i + j] = R[3 * i] * part->inertia[j] + R[3 * i + 1] * part->inertia[3 + j] +
                            R[3 * i + 2] * part->inertia[6 + j];
        }
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) {
            const ecp_real square = i == j ? ecp_i_dot(d, d) : ECP_R(0);
            sum.inertia[3 * i + j] +=
                ecp_i_dot(RI + 3 * i, R + 3 * j) + m1 * share * (square - d[i] * d[j]);
            sum.inertia[3 * j + i] = sum.inertia[3 * i + j];
        }
    }
    sum.mass = m;
    *total = sum;
}
/* >>world ================================================================================= */

/* the kind of a body, and the body of a part, whose index is free; the rest of it is zero */
enum { ECP_I_FREE = -1 };

typedef struct ecp_i_body {
    ecp_real mass, length; /* length: of the body's inertia, sqrt(trace(I) / mass), about */
    ecp_real inertia[9];
    ecp_real x[3], q[4], v[6]; /* v: linear, then angular */
    /* what x, v and q could not hold: the exact sums are x + x_carry, v + v_carry and q + q_carry */
    ecp_real x_carry[3], v_carry[6], q_carry[4];
    ecp_real force[6], impulse[6]; /* applied since the last step */
    int kind;
    int asleep; /* 1: the last step left it and its whole island as they were, see >>sleep (one that is
                   not dynamic: left it as it was); 2: the same, but a pair of it that touches was left out */
} ecp_i_body;

/* a posed primitive */
typedef struct ecp_i_part {
    ecp_shape shape;
    ecp_material material;
    ecp_real position[3], rotation[9];
    ecp_real box_centre[3], box_half[3]; /* bounds along the body's axes; a half-space has none */
    int body;
    uint32_t category, collides_with;
} ecp_i_part;

/* A patch as it is kept from step to step: the warm start and the contact report. Its multipliers
   are max_inequalities reals in the world's array, those of A before those of B. */
typedef struct ecp_i_patch {
    ecp_contact contact;
    ecp_real a[3];       /* the ECP in the frame of shape_a */
    signed char guess;   /* set by ecp_guess_ecp: only `a` means something */
    signed char centred; /* 1: the solution is ECP_CENTRED's, -1: that was tried in vain */
    signed char course;  /* how its island was solved: ECP_I_GATHERED and others */
} ecp_i_patch;

/* what a step was asked for, as far as its result depends on it */
typedef struct ecp_i_asked {
    ecp_real tolerance;
    int sleep, rule, max_iterations, max_total_iterations, fallbacks;
} ecp_i_asked;

struct ecp_world {
    ecp_world_desc desc;
    int bodies, shapes, patches;   /* bodies and shapes: indices in use up to the highest one */
    int lowest_body, lowest_shape; /* no index below is free */
    ecp_real last_h;               /* of the last step, for which the patches' impulses are */
    ecp_i_asked asked;             /* of the last step, zero if that knew no sleep */
    int advancing; /* within ecp_advance: bodies stay, and the gyroscopic moment is always p_vp's */
    size_t bodies_at, parts_at, patches_at, multipliers_at, state_bytes, bytes;
};

/* Blocks are cut off one after the other, and some from the other end, the stack; with base NULL
   only the sizes of the former are added up. */
typedef struct ecp_i_arena {
    unsigned char *base;
    size_t used, top, high, low, most; /* most: high-water mark of both ends together */
    size_t size, wanted;               /* wanted: how much would have done, when overflow is set */
    int overflow;
} ecp_i_arena;

static ecp_i_arena ecp_i_arena_over(void *base, size_t size)
{
    ecp_i_arena a;
    a.base = (unsigned char *)base;
    a.size = a.top = a.low = base ? size & ~(size_t)7 : (size_t)-1;
    a.used = a.high = a.most = a.wanted = 0;
    a.overflow = 0;
    return a;
}

/* is a * b, with 7 to spare, a size_t? (Both are small as a rule, and divisions are slow.) */
static int ecp_i_fits(size_t a, size_t b)
{
    return ((a | b) >> (4 * sizeof(size_t) - 1)) == 0 || b == 0 || a <= ((size_t)-1 - 7) / b;
}

static size_t ecp_i_bytes(size_t count, size_t size)
{
    return ecp_i_fits(count, size) ? (count * size + 7) & ~(size_t)7 : (size_t)-1;
}

/* how far the two ends are, for the high-water marks: called before either gives anything back */
static void ecp_i_arena_mark(ecp_i_arena *a)
{
    if (a->used > a->high) a->high = a->used;
    if (a->top < a->low) a->low = a->top;
    if (a->used + (a->size - a->top) > a->most) a->most = a->used + (a->size - a->top);
}

/* gives back what was taken since the ends were there */
static void ecp_i_release(ecp_i_arena *a, size_t used, size_t top)
{
    ecp_i_arena_mark(a);
    a->used = used;
    a->top = top;
}

static void *ecp_i_out_of_memory(ecp_i_arena *a, size_t bytes)
{
    a->overflow = 1;
    a->wanted = a->used + (a->size - a->top) + bytes;
    return NULL;
}

static void *ecp_i_take(ecp_i_arena *arena, size_t count, size_t size)
{
    size_t at = arena->used, bytes = ecp_i_bytes(count, size);
    if (bytes > arena->top - at) return ecp_i_out_of_memory(arena, bytes);
    arena->used += bytes;
    return arena->base ? (void *)(arena->base + at) : NULL;
}

/* rows x columns reals from the stack; what was taken before from either end stays */
static ecp_real *ecp_i_take_stack(ecp_i_arena *arena, int rows, int columns)
{
    size_t bytes = ecp_i_bytes((size_t)rows * (size_t)columns, sizeof(ecp_real));
    if (bytes > arena->top - arena->used) return (ecp_real *)ecp_i_out_of_memory(arena, bytes);
    arena->top -= bytes;
    return (ecp_real *)(void *)(arena->base + arena->top);
}

static ecp_real *ecp_i_take_reals(ecp_i_arena *arena, int rows, int columns)
{
    if (!ecp_i_fits((size_t)rows, (size_t)columns)) arena->overflow = 1;
    return (ecp_real *)ecp_i_take(arena, (size_t)rows * (size_t)columns, sizeof(ecp_real));
}

static int *ecp_i_take_ints(ecp_i_arena *arena, int count)
{
    return (int *)ecp_i_take(arena, (size_t)count, sizeof(int));
}

/* what begins so many bytes after the head of the block: part of the caller's block, which is not const */
static void *ecp_i_inside(const ecp_world *w, size_t at) { return (void *)((uintptr_t)w + at); }

static ecp_i_body *ecp_i_bodies(const ecp_world *w)
{
    return (ecp_i_body *)ecp_i_inside(w, w->bodies_at);
}

static ecp_i_part *ecp_i_parts(const ecp_world *w)
{
    return (ecp_i_part *)ecp_i_inside(w, w->parts_at);
}

static ecp_i_patch *ecp_i_patches(const ecp_world *w)
{
    return (ecp_i_patch *)ecp_i_inside(w, w->patches_at);
}

/* the multipliers of patch number i */
static ecp_real *ecp_i_multipliers(const ecp_world *w, int i)
{
    return (ecp_real *)ecp_i_inside(w, w->multipliers_at) + i * w->desc.max_inequalities;
}

/* the part of the block that a snapshot needs; offsets go to *w */
static void ecp_i_carve_state(ecp_i_arena *arena, ecp_world *w)
{
    const ecp_world_desc *d = &w->desc;
    ecp_i_take(arena, 1, sizeof(ecp_world));
    w->bodies_at = arena->used;
    ecp_i_take(arena, (size_t)d->max_bodies, sizeof(ecp_i_body));
    w->parts_at = arena->used;
    ecp_i_take(arena, (size_t)d->max_shapes, sizeof(ecp_i_part));
    w->patches_at = arena->used;
    ecp_i_take(arena, (size_t)d->max_patches, sizeof(ecp_i_patch));
    w->multipliers_at = arena->used;
    ecp_i_take_reals(arena, d->max_patches, d->max_inequalities);
    w->state_bytes = arena->used;
}

ECP_DEF const char *ecp_status_string(ecp_status status)
{
    switch (status) {
#define ECP_I_CASE(name, value, text)                                                              \
    case name: return text;
        ECP_STATUS_LIST(ECP_I_CASE)
#undef ECP_I_CASE
    default: return "not a status of this library";
    }
}

ECP_DEF ecp_world_desc ecp_world_desc_default(void)
{
    ecp_world_desc d;
    d.max_bodies = 8;
    d.max_shapes = 32;
    d.max_patches = 16;
    d.max_inequalities = 12;
    ecp_i_set3(0, 0, ECP_R(-9.8), d.gravity);
    d.solver_bytes = 0;
    d.advance_order = 0;
    return d;
}

ECP_DEF size_t ecp_world_state_size(const ecp_world *world)
{
    return world ? world->state_bytes : 0;
}

ECP_DEF ecp_status ecp_world_set_gravity(ecp_world *world, const ecp_real gravity[3])
{
    if (!world || !gravity) return ECP_BAD_POINTER;
    if (!ecp_i_all_finite(3, gravity)) return ECP_NOT_FINITE;
    ecp_i_copy3(gravity, world->desc.gravity);
    world->asked.sleep = 0; /* wakes everything */
    return ECP_OK;
}

ECP_DEF int ecp_world_body_count(const ecp_world *world) { return world ? world->bodies : 0; }
ECP_DEF int ecp_world_shape_count(const ecp_world *world) { return world ? world->shapes : 0; }

/* >>bodies */

ECP_DEF ecp_material ecp_material_default(void)
{
    ecp_material m;
    m.mu = ECP_R(0.5);
    m.e_t = 1;
    m.e_o = 1;
    m.e_r = 0;
    ecp_i_set3(0, 0, 0, m.direction);
    return m;
}

ECP_DEF ecp_body_desc ecp_body_desc_default(void)
{
    ecp_body_desc d;
    ECPSIM_MEMSET(&d, 0, sizeof d);
    d.kind = ECP_DYNAMIC;
    d.mass = 1;
    d.inertia[0] = d.inertia[4] = d.inertia[8] = 1;
    d.rotation[0] = 1;
    return d;
}

/* A solid's inertia is positive definite, and none of the principal moments exceeds the sum of the
   others: (trace / 2) I - inertia, the second moments of mass, is positive semidefinite. Rounding
   of the caller's numbers is forgiven. */
static ecp_status ecp_i_check_inertia(const ecp_real inertia[9])
{
    ecp_real trace = inertia[0] + inertia[4] + inertia[8], S[9], slack = 64 * ECP_I_EPSILON;
    int i, j;
    if (!(trace > 0)) return ECP_BAD_INERTIA;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < i; j++) {
            if (ecp_i_abs(inertia[3 * i + j] - inertia[3 * j + i]) > slack * trace) {
                return ECP_BAD_INERTIA;
            }
        }
    }
    for (i = 0; i < 9; i++) S[i] = inertia[i] / trace;
    if (!ecp_i_cholesky3(S)) return ECP_BAD_INERTIA;
    for (i = 0; i < 9; i++) {
        S[i] = (i % 4 == 0 ? ECP_R(0.5) + slack : ECP_R(0)) - inertia[i] / trace;
    }
    return ecp_i_cholesky3(S) ? ECP_OK : ECP_BAD_INERTIA_TRIANGLE;
}

static ecp_status ecp_i_check_pose(const ecp_real *position, const ecp_real *rotation)
{
    ecp_real q[4];
    if (position && !ecp_i_all_finite(3, position)) return ECP_NOT_FINITE;
    if (!rotation) return ECP_OK;
    if (!ecp_i_all_finite(4, rotation)) return ECP_NOT_FINITE;
    return ecp_i_quat_unit(rotation, q) ? ECP_OK : ECP_BAD_ROTATION;
}

/* the body with this index, or NULL where there is none */
static ecp_i_body *ecp_i_find_body(const ecp_world *w, int body)
{
    if (body < 0 || body >= w->bodies || ecp_i_bodies(w)[body].kind == ECP_I_FREE) return NULL;
    return ecp_i_bodies(w) + body;
}

static ecp_i_part *ecp_i_find_part(const ecp_world *w, int shape)
{
    if (shape < 0 || shape >= w->shapes || ecp_i_parts(w)[shape].body == ECP_I_FREE) return NULL;
    return ecp_i_parts(w) + shape;
}

/* the lowest free index; max_bodies, max_shapes where there is none */
static int ecp_i_next_body(const ecp_world *w)
{
    int i = w->lowest_body;
    while (i < w->bodies && ecp_i_bodies(w)[i].kind != ECP_I_FREE) i++;
    return i;
}

static int ecp_i_next_part(const ecp_world *w)
{
    int i = w->lowest_shape;
    while (i < w->shapes && ecp_i_parts(w)[i].body != ECP_I_FREE) i++;
    return i;
}

ECP_DEF ecp_status ecp_body_add(ecp_world *world, const ecp_body_desc *desc, int *body)
{
    ecp_i_body *b;
    ecp_status status;
    int at;
    if (!world || !desc) return ECP_BAD_POINTER;
    if (desc->kind != ECP_STATIC && desc->kind != ECP_KINEMATIC && desc->kind != ECP_DYNAMIC) {
        return ECP_BAD_KIND;
    }
    status = ecp_i_check_pose(desc->position, desc->rotation);
    if (status != ECP_OK) return status;
    if (!ecp_i_all_finite(3, desc->velocity) || !ecp_i_all_finite(3, desc->angular_velocity)) {
        return ECP_NOT_FINITE;
    }
    if (desc->kind == ECP_DYNAMIC) {
        if (!ecp_i_finite(desc->mass) || !ecp_i_all_finite(9, desc->inertia)) {
            return ECP_NOT_FINITE;
        }
        if (!(desc->mass > 0) || !ecp_i_finite(1 / desc->mass)) return ECP_BAD_MASS;
        status = ecp_i_check_inertia(desc->inertia);
        if (status != ECP_OK) return status;
    }
    if (world->advancing) return ECP_BAD_OPTION;
    at = ecp_i_next_body(world);
    if (at >= world->desc.max_bodies) return ECP_CAPACITY;
    b = ecp_i_bodies(world) + at;
    ECPSIM_MEMSET(b, 0, sizeof *b);
    b->kind = (int)desc->kind;
    ecp_i_copy3(desc->position, b->x);
    ecp_i_quat_unit(desc->rotation, b->q);
    if (desc->kind != ECP_STATIC) {
        ecp_i_copy3(desc->velocity, b->v);
        ecp_i_copy3(desc->angular_velocity, b->v + 3);
    }
    if (desc->kind == ECP_DYNAMIC) {
        b->mass = desc->mass;
        ecp_i_copy(9, desc->inertia, b->inertia);
        b->length = ecp_i_power_of_two(
            ecp_i_sqrt((b->inertia[0] + b->inertia[4] + b->inertia[8]) / b->mass));
    }
    world->lowest_body = at + 1;
    if (at == world->bodies) world->bodies++;
    if (body) *body = at;
    return ECP_OK;
}

/* a patch of the body has gone or changed: bodies that are not dynamic do not care, nor does what else lies on them */
static void ecp_i_wake(ecp_world *w, int body)
{
    if (ecp_i_bodies(w)[body].kind == ECP_DYNAMIC) ecp_i_bodies(w)[body].asleep = 0;
}

/* drops the patches of parts that are gone, and wakes their bodies; the others keep their order */
static void ecp_i_drop_patches(ecp_world *w)
{
    ecp_i_patch *list = ecp_i_patches(w);
    int i, kept = 0;
    for (i = 0; i < w->patches; i++) {
        const ecp_contact *c = &list[i].contact;
        if (!ecp_i_find_part(w, c->shape_a) || !ecp_i_find_part(w, c->shape_b)) {
            ecp_i_wake(w, c->body_a);
            ecp_i_wake(w, c->body_b);
            continue;
        }
        if (kept < i) {
            ECPSIM_MEMCPY(list + kept, list + i, sizeof *list);
            ECPSIM_MEMCPY(ecp_i_multipliers(w, kept), ecp_i_multipliers(w, i),
                          (size_t)w->desc.max_inequalities * sizeof(ecp_real));
        }
        kept++;
    }
    w->patches = kept;
}

ECP_DEF ecp_status ecp_body_remove(ecp_world *world, int body)
{
    ecp_i_body *b;
    ecp_i_part *parts;
    int i;
    if (!world) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    if (world->advancing) return ECP_BAD_OPTION;
    ECPSIM_MEMSET(b, 0, sizeof *b);
    b->kind = ECP_I_FREE;
    if (body < world->lowest_body) world->lowest_body = body;
    parts = ecp_i_parts(world);
    for (i = world->shapes - 1; i >= 0; i--) {
        if (parts[i].body != body) continue;
        ECPSIM_MEMSET(parts + i, 0, sizeof *parts);
        parts[i].body = ECP_I_FREE;
        if (i < world->lowest_shape) world->lowest_shape = i;
    }
    ecp_i_drop_patches(world);
    /* beyond the highest index the block is as if nothing had been there */
    while (world->bodies > 0 && ecp_i_bodies(world)[world->bodies - 1].kind == ECP_I_FREE) {
        ecp_i_bodies(world)[--world->bodies].kind = 0;
    }
    while (world->shapes > 0 && parts[world->shapes - 1].body == ECP_I_FREE) {
        parts[--world->shapes].body = 0;
    }
    return ECP_OK;
}

static ecp_status ecp_i_check_material(const ecp_material *m)
{
    if (!ecp_i_all_finite(4, &m->mu) || !ecp_i_all_finite(3, m->direction)) return ECP_NOT_FINITE;
    if (m->mu < 0) return ECP_BAD_FRICTION;
    return m->e_t > 0 && m->e_o > 0 && m->e_r >= 0 ? ECP_OK : ECP_BAD_ELLIPSOID;
}

static void ecp_i_part_bounds(ecp_i_part *p)
{
    ecp_real lo[3], hi[3], centre[3], half[3];
    int j, k;
    if (p->shape.kind == ECP_HALF_SPACE) return;
    ecp_i_shape_bounds(&p->shape, lo, hi);
    for (k = 0; k < 3; k++) {
        centre[k] = (lo[k] + hi[k]) / 2;
        half[k] = (hi[k] - lo[k]) / 2;
    }
    ecp_i_mul(p->rotation, centre, p->box_centre);
    ecp_i_add(p->box_centre, p->position, p->box_centre);
    for (j = 0; j < 3; j++) {
        for (k = 0; k < 3; k++) p->box_half[j] += ecp_i_abs(p->rotation[3 * j + k]) * half[k];
    }
}

/* Member by member, as padding that the caller's copies may have lost must stay zero: equal worlds are equal
   bytes. */
static void ecp_i_shape_copy(const ecp_shape *s, ecp_shape *out)
{
    out->cls = s->cls;
    out->kind = s->kind;
    out->inequalities = s->inequalities;
    out->vertex_count = s->vertex_count;
    ecp_i_copy(4, s->size, out->size);
    ecp_i_copy3(s->centre, out->centre);
    out->radius = s->radius;
    out->planes = s->planes;
    out->vertices = s->vertices;
    out->user = s->user;
}

ECP_DEF ecp_status ecp_body_add_shape(ecp_world *world, int body, const ecp_shape *shape,
                                      const ecp_real position[3], const ecp_real rotation[4],
                                      const ecp_material *material, int *shape_index)
{
    ecp_material m = ecp_material_default();
    ecp_real q[4];
    ecp_status status;
    const ecp_i_body *b;
    ecp_i_part *p;
    int at;
    if (!world || !shape || !shape->cls) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    if (shape->kind == ECP_HALF_SPACE && b->kind == ECP_DYNAMIC) return ECP_BAD_KIND;
    status = ecp_i_check_pose(position, rotation);
    if (status != ECP_OK) return status;
    if (material) m = *material;
    status = ecp_i_check_material(&m);
    if (status != ECP_OK) return status;
    if (world->advancing) return ECP_BAD_OPTION;
    at = ecp_i_next_part(world);
    if (at >= world->desc.max_shapes || shape->inequalities > world->desc.max_inequalities) {
        return ECP_CAPACITY;
    }
    p = ecp_i_parts(world) + at;
    ECPSIM_MEMSET(p, 0, sizeof *p);
    ecp_i_shape_copy(shape, &p->shape);
    p->material = m;
    p->body = body;
    p->category = p->collides_with = 0xffffffffu;
    if (position) ecp_i_copy3(position, p->position);
    q[0] = 1;
    ecp_i_set3(0, 0, 0, q + 1);
    if (rotation) ecp_i_quat_unit(rotation, q);
    ecp_quat_to_matrix(q, p->rotation);
    ecp_i_part_bounds(p);
    ecp_i_bodies(world)[body].asleep = 0;
    world->lowest_shape = at + 1;
    if (at == world->shapes) world->shapes++;
    if (shape_index) *shape_index = at;
    return ECP_OK;
}

ECP_DEF ecp_status ecp_body_get_state(const ecp_world *world, int body, ecp_real position[3],
                                      ecp_real rotation[4], ecp_real velocity[3],
                                      ecp_real angular_velocity[3])
{
    const ecp_i_body *b;
    if (!world) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    if (position) ecp_i_copy3(b->x, position);
    if (rotation) ecp_i_copy(4, b->q, rotation);
    if (velocity) ecp_i_copy3(b->v, velocity);
    if (angular_velocity) ecp_i_copy3(b->v + 3, angular_velocity);
    return ECP_OK;
}

/* A vector from outside in the place of one with a carry; 0 if there is none, or the one that was read: that leaves
   the carry, which nobody can read. */
static int ecp_i_put3(const ecp_real *from, ecp_real *to, ecp_real *carry)
{
    if (!from || ecp_i_equal(from, to)) return 0;
    ecp_i_copy3(from, to);
    ecp_i_set3(0, 0, 0, carry);
    return 1;
}

ECP_DEF ecp_status ecp_body_set_state(ecp_world *world, int body, const ecp_real position[3],
                                      const ecp_real rotation[4], const ecp_real velocity[3],
                                      const ecp_real angular_velocity[3])
{
    ecp_i_body *b;
    ecp_status status;
    int other;
    if (!world) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    status = ecp_i_check_pose(position, rotation);
    if (status != ECP_OK) return status;
    if ((velocity && !ecp_i_all_finite(3, velocity)) ||
        (angular_velocity && !ecp_i_all_finite(3, angular_velocity))) {
        return ECP_NOT_FINITE;
    }
    if (b->kind == ECP_STATIC && ((velocity && !ecp_i_is_zero(velocity)) ||
                                  (angular_velocity && !ecp_i_is_zero(angular_velocity)))) {
        return ECP_BAD_KIND;
    }
    other = ecp_i_put3(position, b->x, b->x_carry);
    other |= ecp_i_put3(velocity, b->v, b->v_carry);
    other |= ecp_i_put3(angular_velocity, b->v + 3, b->v_carry + 3);
    /* a length is one but for rounding */
    if (rotation && !ecp_i_same_bytes(rotation, b->q, sizeof b->q)) {
        ecp_i_quat_unit(rotation, b->q);
        ECPSIM_MEMSET(b->q_carry, 0, sizeof b->q_carry);
        other = 1;
    }
    if (other || !(position || rotation || velocity || angular_velocity)) b->asleep = 0;
    return ECP_OK;
}

/* adds a linear load, its moment when it acts at a point, and an angular load */
static ecp_status ecp_i_apply(ecp_world *world, int body, const ecp_real *linear,
                              const ecp_real *point, const ecp_real *angular, int impulse)
{
    ecp_i_body *b;
    ecp_real arm[3], sum[6], *total;
    int k;
    if (!world || (!linear && !angular)) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    if (b->kind != ECP_DYNAMIC) return ECP_BAD_KIND;
    total = impulse ? b->impulse : b->force;
    ecp_i_copy(6, total, sum);
    if (linear) ecp_i_add(sum, linear, sum);
    if (linear && point) {
        ecp_i_sub(point, b->x, arm);
        ecp_i_add_cross(arm, linear, sum + 3);
    }
    if (angular) ecp_i_add(sum + 3, angular, sum + 3);
    if (!ecp_i_all_finite(6, sum)) return ECP_NOT_FINITE;
    for (k = 0; k < 6; k++) {
        if (ecp_i_abs(total[k] - sum[k]) > 0) b->asleep = 0;
        total[k] = sum[k];
    }
    return ECP_OK;
}

ECP_DEF ecp_status ecp_body_apply_force(ecp_world *world, int body, const ecp_real force[3],
                                        const ecp_real *point)
{
    return ecp_i_apply(world, body, force, point, NULL, 0);
}

ECP_DEF ecp_status ecp_body_apply_torque(ecp_world *world, int body, const ecp_real torque[3])
{
    return ecp_i_apply(world, body, NULL, NULL, torque, 0);
}

ECP_DEF ecp_status ecp_body_apply_impulse(ecp_world *world, int body, const ecp_real impulse[3],
                                          const ecp_real *point)
{
    return ecp_i_apply(world, body, impulse, point, NULL, 1);
}

ECP_DEF ecp_status ecp_body_apply_angular_impulse(ecp_world *world, int body,
                                                  const ecp_real impulse[3])
{
    return ecp_i_apply(world, body, NULL, NULL, impulse, 1);
}

ECP_DEF ecp_status ecp_body_clear_loads(ecp_world *world, int body)
{
    ecp_i_body *b;
    if (!world) return ECP_BAD_POINTER;
    b = ecp_i_find_body(world, body);
    if (!b) return ECP_BAD_INDEX;
    if (b->kind != ECP_DYNAMIC) return ECP_BAD_KIND;
    ECPSIM_MEMSET(b->force, 0, sizeof b->force);
    ECPSIM_MEMSET(b->impulse, 0, sizeof b->impulse);
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_get(const ecp_world *world, int shape_index, const ecp_shape **shape,
                                 int *body, ecp_real position[3], ecp_real rotation[9])
{
    const ecp_i_part *p;
    const ecp_i_body *b;
    ecp_real R[9], offset[3];
    if (!world) return ECP_BAD_POINTER;
    p = ecp_i_find_part(world, shape_index);
    if (!p) return ECP_BAD_INDEX;
    b = ecp_i_bodies(world) + p->body;
    ecp_quat_to_matrix(b->q, R);
    if (shape) *shape = &p->shape;
    if (body) *body = p->body;
    if (position) {
        ecp_i_mul(R, p->position, offset);
        ecp_i_add(b->x, offset, position);
    }
    if (rotation) ecp_i_matmul(R, p->rotation, rotation);
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_set_filter(ecp_world *world, int shape_index, uint32_t category,
                                        uint32_t collides_with)
{
    ecp_i_part *p;
    if (!world) return ECP_BAD_POINTER;
    p = ecp_i_find_part(world, shape_index);
    if (!p) return ECP_BAD_INDEX;
    if (p->category == category && p->collides_with == collides_with) return ECP_OK;
    p->category = category;
    p->collides_with = collides_with;
    ecp_i_bodies(world)[p->body].asleep = 0;
    return ECP_OK;
}

ECP_DEF ecp_status ecp_shape_set_material(ecp_world *world, int shape_index,
                                          const ecp_material *material)
{
    ecp_material m = ecp_material_default();
    ecp_i_part *p;
    ecp_status status;
    int i;
    if (!world) return ECP_BAD_POINTER;
    p = ecp_i_find_part(world, shape_index);
    if (!p) return ECP_BAD_INDEX;
    if (material) m = *material;
    status = ecp_i_check_material(&m);
    if (status != ECP_OK) return status;
    if (ecp_i_same_bytes(&p->material, &m, sizeof m)) return ECP_OK;
    p->material = m;
    ecp_i_bodies(world)[p->body].asleep = 0;
    /* what was the rule's solution need not be it any more */
    for (i = 0; ECP_I_CENTRING && i < world->patches; i++) {
        ecp_i_patch *patch = ecp_i_patches(world) + i;
        if (patch->contact.shape_a == shape_index || patch->contact.shape_b == shape_index)
            patch->centred = 0;
    }
    return ECP_OK;
}

/* can the two ever make a patch, wherever they are? */
static int ecp_i_may_meet(const ecp_i_part *a, const ecp_i_part *b)
{
    return a->body != ECP_I_FREE && b->body != ECP_I_FREE &&
           (a->category & b->collides_with) != 0 && (b->category & a->collides_with) != 0;
}

/* >>motion ================================================================================
   A body within a step: what is known at its beginning, and where a trial velocity takes it. */

typedef struct ecp_i_motion {
    const ecp_i_body *body;
    int dynamic, island;         /* island: the lowest body of it */
    int quiet;                   /* may be left out, as far as is known when the step begins */
    int asleep, stirred;         /* is left out; its patches are not the last step's */
    int next_body, first_pair;   /* of the island, or -1 (first_pair: at its lowest body) */
    int at;                      /* of its six unknowns in the island's vector */
    int loads;                   /* patches that carry it */
    int carries;                 /* patches that it carries */
    ecp_real load;               /* its mass and what it carries, on these patches together; without
                                    gravity: the mass of the heaviest but next_ready */
    struct ecp_i_pair *rests_on; /* the first of the patches that carry it, by next_below */
    struct ecp_i_motion *next_ready; /* without gravity: the heaviest of those that it touches */
    int turns;                       /* how many times ecp_i_move has set T, J and R */
    ecp_real R0[9];                  /* rotation at the beginning of the step */
    ecp_real inertia[9];          /* about the centre of mass, world axes, beginning of the step */
    ecp_real whole[6];            /* p_app + p_vp of equ:discrete_NE */
    ecp_real kick[6];             /* what the equations take of it; all, but for ecp_i_ramp */
    ecp_real free[6];             /* the velocity change without contacts, M^-1 kick */
    ecp_real from_origin;         /* |x| at the beginning of the step */
    ecp_real drift, swing;        /* h |free|, linear; h (|w| + |free|), angular */
    ecp_real mass, length, speed; /* units: of mass, of length, of velocity (vs, of the island) */
    /* at the trial velocity */
    ecp_real dv[6], v[6]; /* change over the step, and velocity at its end */
    ecp_real dx[3];       /* displacement */
    ecp_real T[9], J[9];  /* the turn less the identity, and its derivative (ecp_i_cayley) */
    ecp_real R[9];        /* rotation at the end, R0 + T R0 */
    ecp_real residual[6]; /* of equ:discrete_NE, unscaled */
    ecp_real floor[2];    /* the sizes of its terms, linear and angular, for the rounding floor */
    ecp_real noise;       /* of the velocity, where it meets other bodies, m/s */
    ecp_real jitter;      /* what closing gaps to their rounding error does to it, m/s */
    /* the share of both that acts along each axis and about it (ecp_i_noise_share) */
    ecp_real along[ECP_I_PAIRS ? 6 : 1];
} ecp_i_motion;

/* Moves the body to where the velocity change dv takes it: v = v0 + dv, x = x0 + h v. Changes are
   the unknowns, not velocities, and displacements are kept apart from positions, so that small
   steps and places far from the origin cost no digits. A body that is there already, or that
   turns as before or not at all, costs little. */
static void ecp_i_move(ecp_i_motion *m, ecp_real h, const ecp_real dv[6])
{
    const ecp_real *v = m->body->v, *carry = m->body->v_carry;
    ecp_real w[3], sum[6];
    int k;
    if (ECP_I_FAST && m->turns > 0 && ecp_i_equal(m->dv, dv) && ecp_i_equal(m->dv + 3, dv + 3))
        return;
    ecp_i_copy3(m->v + 3, w);
    ecp_i_copy(6, dv, m->dv);
    ecp_i_add(carry, dv, sum);
    ecp_i_add(carry + 3, dv + 3, sum + 3);
    ecp_i_add(v, sum, m->v);
    ecp_i_add(v + 3, sum + 3, m->v + 3);
    ecp_i_scale(h, m->v, m->dx);
    if (ECP_I_FAST && m->turns > 0 && ecp_i_equal(m->v + 3, w)) return;
    if (ECP_I_FAST) m->turns++;
    if (ECP_I_FAST && ecp_i_is_zero(m->v + 3)) {
        ECPSIM_MEMSET(m->T, 0, sizeof m->T);
        ECPSIM_MEMSET(m->J, 0, sizeof m->J);
        m->J[0] = m->J[4] = m->J[8] = h;
        ecp_i_copy(9, m->R0, m->R);
        return;
    }
    ecp_i_cayley(m->v + 3, h, m->T, m->J);
    ecp_i_matmul(m->T, m->R0, m->R);
    for (k = 0; k < 9; k++) m->R[k] += m->R0[k];
}

/* L = I w, the inertia I in the axes R of the body. By way of these: in others the rounding of a large
   moment of inertia is that of a small one, and a needle spins up from nothing in single precision. */
static void ecp_i_spin_momentum(const ecp_real R[9], const ecp_real inertia[9], const ecp_real w[3],
                                ecp_real L[3])
{
    ecp_real own[3], turned[3];
    ecp_i_mul_t(R, w, own);
    ecp_i_mul(inertia, own, turned);
    ecp_i_mul(R, turned, L);
}

/* what M^-1 makes of an impulse (linear, angular) */
static void ecp_i_velocity_change(const ecp_i_motion *m, const ecp_real impulse[6], ecp_real dv[6])
{
    ecp_real own[3];
    ecp_i_scale(1 / m->body->mass, impulse, dv);
    ecp_i_copy3(impulse + 3, dv + 3);
    if (ECP_I_FAST && ecp_i_is_zero(dv + 3)) return;
    ecp_i_mul_t(m->R0, dv + 3, own);
    ecp_i_solve3(m->body->inertia, own);
    ecp_i_mul(m->R0, own, dv + 3);
}

/* w of I w + h w x I w = I w0: a backward Euler step of free rotation. (A turn about w leaves w as it
   is, so in the body's axes this is Euler's equation, and w.I w never grows.) Newton, cut where |f|
   would grow; 0 if it does not get there. */
static int ecp_i_implicit_rotation(const ecp_real inertia[9], const ecp_real w0[3], ecp_real h,
                                   ecp_real w[3])
{
    ecp_real f[3], L[3], J[12], tau[3], x[3]; /* J: f last */
    ecp_real size = 0, unit = 0, before = -1, t = 1;
    int piv[3], k, i, j;
    ecp_i_copy3(w0, w);
    ecp_i_set3(0, 0, 0, x);
    for (k = 0; k < 60; k++) {
        ecp_real back[3], lost[3], cross[9], turned[9];
        ecp_i_mul(inertia, w, L);
        ecp_i_cross(w, L, f);
        ecp_i_scale(h, f, f);
        ecp_i_sub(w, w0, back);
        ecp_i_mul(inertia, back, lost);
        ecp_i_add(f, lost, f);
        size = ecp_i_norm(f);
        unit = ecp_i_norm(L) * (1 + h * ecp_i_norm(w));
        if (size <= 4 * ECP_I_EPSILON * unit) return 1;
        if (before >= 0 && !(size < before)) {
            /* half of the last step back */
            t /= 2;
            ecp_i_axpy(w, t, x, w);
            continue;
        }
        before = size;
        t = 1;
        /* J = I + h ([w] I - [I w]) */
        ecp_i_skew(w, cross);
        ecp_i_matmul(cross, inertia, turned);
        ecp_i_skew(L, cross);
        for (i = 0; i < 3; i++) {
            for (j = 0; j < 3; j++) {
                int at = 3 * i + j;
                J[4 * i + j] = inertia[at] + h * turned[at] - h * cross[at];
            }
            J[4 * i + 3] = f[i];
        }
        if (ecp_i_qr(3, 3, 4, J, 4, tau, piv, 0, 0) < 3) break;
        ecp_i_solve_rows(3, 4, J, 4);
        for (i = 0; i < 3; i++) x[piv[i]] = J[4 * i + 3];
        ecp_i_sub(w, x, w);
    }
    return size <= ECP_R(1e-6) * unit;
}

/* The gyroscopic moment w x I w of p_vp. The paper takes it where the step begins, which gains energy
   as (h w)^2 and explodes when the body turns far within a step. Where it would change the velocity
   by more than a twentieth, in the norm of the energy, it is the mean of backward Euler steps: of one,
   or, as from h |w| = 1.8 on Newton's method may not find its root, of up to 16; or none where even
   that is not to be had, as with needles in single precision that turn more than once. */
static void ecp_i_gyroscopic(const ecp_real inertia[9], const ecp_real w[3], ecp_real h,
                             ecp_real moment[3])
{
    ecp_real Iw[3], change[3];
    int parts, k, found = 0;
    ecp_i_set3(0, 0, 0, moment);
    if (ECP_I_FAST && ecp_i_is_zero(w)) return;
    ecp_i_mul(inertia, w, Iw);
    ecp_i_cross(w, Iw, moment);
    if (ECP_I_FAST && ecp_i_is_zero(moment)) return;
    ecp_i_copy3(moment, change);
    ecp_i_solve3(inertia, change);
    if (400 * h * h * ecp_i_dot(change, moment) <= ecp_i_dot(w, Iw)) return;
    for (parts = 1; parts <= 16 && !found; parts *= 2) {
        ecp_i_copy3(w, change);
        for (k = 0, found = 1; k < parts && found; k++) {
            ecp_i_copy3(change, Iw);
            found = ecp_i_implicit_rotation(inertia, Iw, h / (ecp_real)parts, change);
        }
    }
    if (!found) ecp_i_copy3(w, change);
    ecp_i_sub(w, change, change);
    ecp_i_mul(inertia, change, moment);
    ecp_i_scale(1 / h, moment, moment);
}

/* p_app: weight, forces and impulses; p_vp: the gyroscopic moment -h w x I w, at the beginning. *m is
   zero before. */
static void ecp_i_predict(const ecp_world *w, const ecp_i_body *b, ecp_real h, ecp_i_motion *m)
{
    ecp_real none[6], gyro[3], spin[3];
    int k;
    ECPSIM_MEMSET(none, 0, sizeof none);
    m->body = b;
    m->dynamic = b->kind == ECP_DYNAMIC;
    m->island = -1;
    ecp_quat_to_matrix(b->q, m->R0);
    m->swing = h * ecp_i_norm(b->v + 3);
    if (m->dynamic) {
        m->mass = b->mass;
        m->length = b->length;
        ecp_i_congruence(m->R0, b->inertia, m->inertia);
        if (w->advancing) {
            ecp_i_spin_momentum(m->R0, b->inertia, b->v + 3, spin);
            ecp_i_cross(b->v + 3, spin, gyro);
        } else {
            ecp_i_gyroscopic(m->inertia, b->v + 3, h, gyro);
        }
        for (k = 0; k < 3; k++) {
            m->kick[k] = h * (b->mass * w->desc.gravity[k] + b->force[k]) + b->impulse[k];
            m->kick[3 + k] = h * (b->force[3 + k] - gyro[k]) + b->impulse[3 + k];
        }
        ecp_i_velocity_change(m, m->kick, m->free);
        ecp_i_copy(6, m->kick, m->whole);
        m->drift = h * ecp_i_norm(m->free);
        m->swing += h * ecp_i_norm(m->free + 3);
    }
    m->from_origin = ecp_i_norm(b->x);
    ecp_i_move(m, h, m->dynamic ? m->free : none);
}

/* >>equations =============================================================================
   One patch, in the form of docs/model.md. Unknowns: the ECP a on A (in the frame of the primitive,
   in lengths L), the multipliers l of f, and against a half-space p = (p_n / P, y). Between two
   convex primitives also the signed gap d (in h vs) and the multipliers m of g:

     n = sum_i l_i grad f_i(a),  a2 = a + d n,  b = a2 in the frame of B
     half-space:   sum_i l_i grad f_i(a) - n = 0          (n is known)
     pair:         (n.n - 1) / 2 = 0,   n + sum_j m_j grad g_j(b) = 0
     0 <= l_i  _|_ -f_i(a) / L >= 0,    0 <= m_j _|_ -g_j(b) / L >= 0
     0 <= p_n  _|_ d >= 0
     y - Proj_{|.| <= mu p_n} (y - rho w) = 0,   w = (e_t v_t, e_o v_o, e_r w_n)

   with y = (p_t / e_t, p_o / e_o, p_r / e_r). The rows stand in the order of these lines, with the
   multipliers' rows before the gap's. Contact normal N = -n, from B to A. */

/* what a patch has of B if that is no half-space */
typedef struct ecp_i_side_b {
    ecp_real rest; /* 0, or the gap that counts as closed (ecp_i_let_gap_be) */
    ecp_real *fb, *gb, *fixed_b, *slope_b; /* of g, like fa, ga and the others of f */
    int *active_b;
    ecp_real rb2[3], b_local[3]; /* a2, from B's centre of mass and in the frame of B */
    ecp_real Hb[9];
    ecp_real along[3]; /* fixes the tangents at the normal that there is */
    int axis;          /* which one that is, if it stands in for the direction; or -1 */
    /* the tangents, and that axis, at the point of the last Newton step */
    ecp_real last_t[3], last_o[3];
    int last_axis;
    int bears;      /* takes a share of the load to start with */
    int set;        /* where the patch is in the working set (ecp_i_island_gather) */
    ecp_real depth; /* how deep the two are in each other at the last solution without it */
} ecp_i_side_b;

/* A patch is in the equations, or in them since the last solution; or left out, left out since the last
   solution, or was tried since then in vain. */
enum { ECP_I_IN, ECP_I_NEW, ECP_I_OUT, ECP_I_LET, ECP_I_TRIED };

/* What is asked for most often stands first: its place in the structure is short in the code. */
typedef struct ecp_i_pair {
    const ecp_i_part *a, *b;
    ecp_i_motion *ma, *mb;
    int nl, nm, nf; /* numbers of multipliers of f and g, of friction rows (0, 2, 3) */
    int plane;      /* B is a half-space */
    int at, count;  /* of its unknowns in the island's vector */
    int shape_a, shape_b;
    ecp_real *fa, *ga;  /* values and gradients of f at a */
    ecp_i_side_b *on_b; /* of a pair */

    /* the Newton block (see elimination) */
    ecp_real *block;
    ecp_real *fixed_a, *slope_a;
    int *active_a, *row_tag, *col_tag, *col_order;
    int kl, km, ny, columns, pivots;
    struct ecp_i_pair *next_here; /* of the patches that are assembled at the same front */
    const ecp_real *left;         /* the values of the unknowns passed on to it */

    int old;             /* this patch in the world's list, or -1 */
    int next_pair;       /* of the island, or -1 */
    ecp_i_patch *record; /* what the step leaves of it, and the multipliers */
    ecp_real *multipliers;
    ecp_i_motion *carried;         /* the body that rests on the other, against gravity */
    struct ecp_i_pair *next_below; /* of the patches that carry the same body */
    unsigned char may_stick;       /* friction does not slip, as the last centring step saw it */
    unsigned char held;            /* friction is left on its limit by centring steps */
    unsigned char open;            /* the impulse is left at zero by them */
    int placed; /* set when fa, ga and what ecp_i_pair_place finds belong to a_local */
    /* the turns of A (ecp_i_motion) for which Qa, turned and ra hold; of B, for which Qb holds, and
       the normal and tangents of a half-space; 0: none */
    int turns_a, turns_b;
    ecp_real mu, e[3], direction[3];
    ecp_real L, V, P;   /* units of length, velocity, impulse */
    ecp_real tilt;      /* and of multipliers in Newton's steps: h V / L, what a step turns */
    ecp_real weight[3]; /* of the load, as an impulse upwards in units P */
    ecp_real rho;       /* in which the error of friction is measured; F has another (ecp_i_rho) */
    ecp_real offset[3]; /* x_A - x_B at the beginning of the step */

    /* at the ECP and the beginning of the step (ecp_i_pair_place) */
    ecp_real a_local[3], ra0[3]; /* the ECP in the frame of A, and from A's centre of mass, world */
    ecp_real N0[3], d0;          /* of a half-space: its normal, and the gap over it */

    /* at the trial point */
    ecp_real cone[3];                /* sum l_i grad f_i, frame of A */
    ecp_real Qa[9], Qb[9];           /* primitive to world */
    ecp_real n[3], N[3], t[3], o[3]; /* world */
    ecp_real c_norm;                 /* |N x along| */
    ecp_real turned[3];              /* what the turn of A adds to ra0 */
    ecp_real ra[3], rb[3];           /* from the centres of mass to a */
    ecp_real d;
    ecp_real d_floor, d_noise; /* rounding error of the gap as a distance, and in its row */
    ecp_real n_noise;          /* and of the rows of the normal, from the last Newton step */
    ecp_real v[3], spin[3];    /* of A relative to B at a */
    ecp_real force[3];         /* impulse on A */
    ecp_real p[4];             /* p_n / P, y */
    ecp_real slip[3];          /* ecp_i_pair_slip */
    ecp_real chord;            /* h, where the slip is measured along the chord of the step; or 0 */
    ecp_real relax;      /* of a relaxed problem, 0 in the true one: tau, which smoothes the rows of
                            complementarity, and the compliance of the contact */
    ecp_real compliance; /* of the contact in a damped Newton step, 0 in others */
    ecp_real Ha[9];
} ecp_i_pair;

/* Is B a half-space? Do A and B move under impulses? How many rows of friction and multipliers of g are
   there, and how many of these are kept in the Newton block? Of what a program does without compilers
   know. */
static int ecp_i_on_plane(const ecp_i_pair *c) { return !ECP_I_PAIRS || c->plane; }
static int ecp_i_moves_a(const ecp_i_pair *c) { return !ECP_I_PAIRS || c->ma->dynamic; }
static int ecp_i_moves_b(const ecp_i_pair *c) { return ECP_I_PAIRS && c->mb->dynamic; }
static int ecp_i_nf(const ecp_i_pair *c) { return ECP_I_FRICTION ? c->nf : 0; }
static int ecp_i_nm(const ecp_i_pair *c) { return ECP_I_PAIRS ? c->nm : 0; }
static int ecp_i_km(const ecp_i_pair *c) { return ECP_I_PAIRS ? c->km : 0; }

/* is the patch left out of the working set? */
static int ecp_i_left_out(const ecp_i_pair *c)
{
    return ECP_I_PAIRS && !c->plane && c->on_b->set >= ECP_I_OUT;
}

/* Only continuation relaxes problems. */
static ecp_real ecp_i_relax(const ecp_i_pair *c)
{
    return (ECPSIM_FALLBACKS)&ECP_FALLBACK_CONTINUATION ? c->relax : ECP_R(0);
}

/* A relaxed problem has its own measure of both sides of a complementarity. */
static ecp_real ecp_i_tilt_unit(const ecp_i_pair *c)
{
    return ecp_i_relax(c) > 0 ? ECP_R(1) : c->tilt;
}

/* Only one of the fallbacks measures slip along the chord. */
static ecp_real ecp_i_chord(const ecp_i_pair *c)
{
    return ECP_I_FRICTION && ((ECPSIM_FALLBACKS)&ECP_FALLBACK_CHORD) != 0 ? c->chord : ECP_R(0);
}

/* how many bodies a patch can move */
#define ECP_I_MOVERS (1 + ECP_I_PAIRS)

static int ecp_i_at_d(const ecp_i_pair *c) { return 3 + c->nl; }
static int ecp_i_at_m(const ecp_i_pair *c) { return 4 + c->nl; }
static int ecp_i_at_p(const ecp_i_pair *c)
{
    return ecp_i_on_plane(c) ? 3 + c->nl : 4 + c->nl + c->nm;
}

/* Fischer-Burmeister a + b - sqrt(a^2 + b^2 + 2 tau^2), smoothed by tau; *r: the root. */
static ecp_real ecp_i_fb_value(ecp_real a, ecp_real b, ecp_real tau, ecp_real *r)
{
    /* where one of the two is zero, as for most multipliers, the root is known */
    if (tau == 0 && (a == 0 || b == 0)) {
        *r = ecp_i_abs(a + b);
        return a + b - *r;
    }
    *r = ecp_i_sqrt(a * a + b * b + 2 * tau * tau);
    /* a + b - r without cancellation where both are positive */
    if (a > 0 && b > 0) return 2 * (a * b - tau * tau) / (a + b + *r);
    return a + b - *r;
}

/* The same without cancellation where one is negative and the other positive. */
static ecp_real ecp_i_fb_mixed(ecp_real least, ecp_real most, ecp_real tau)
{
    ecp_real rest = least * least + 2 * tau * tau;
    return least - rest / (most + ecp_i_sqrt(most * most + rest));
}

/* Its value and its derivatives. At the kink a = b = 0 any of the generalised derivatives will do; this
   one treats both alike. */
static ecp_real ecp_i_fb(ecp_real a, ecp_real b, ecp_real tau, ecp_real *da, ecp_real *db)
{
    ecp_real r, value = ecp_i_fb_value(a, b, tau, &r);
    if (r == 0) {
        *da = *db = ECP_R(0.2928932188134524); /* 1 - 1 / sqrt(2) */
        return 0;
    }
    *da = 1 - a / r;
    *db = 1 - b / r;
    return value;
}

/* Tangents o = N x along normalised, t = o x N. They are fixed by the material's direction; where there is none, by
   the world axis most across the first normal of the step. Where the normal comes to lie along that, the axis most
   across it stands in. So within a step they depend on nothing but the normal: what an unknown means does not depend
   on the points that have been tried before. */
static void ecp_i_tangents(ecp_i_pair *c)
{
    ecp_real *along = c->direction; /* (the normal of a half-space stays what it is) */
    int k, axis = -1;
    if (!ecp_i_on_plane(c)) {
        along = c->on_b->along;
        ecp_i_copy3(c->direction, along);
    }
    ecp_i_cross(c->N, along, c->o);
    c->c_norm = ecp_i_norm(c->o);
    if (!(c->c_norm > ECP_R(1e-3) * ecp_i_norm(c->N))) {
        for (k = 1, axis = 0; k < 3; k++) {
            /* (not by rounding: contacts would change tangents from step to step) */
            if (ecp_i_abs(c->N[k]) < ecp_i_abs(c->N[axis]) - ECP_R(1e-6)) axis = k;
        }
        ecp_i_set3(0, 0, 0, along);
        along[axis] = 1;
        ecp_i_cross(c->N, along, c->o);
        c->c_norm = ecp_i_norm(c->o);
    }
    if (!ecp_i_on_plane(c)) {
        if (ecp_i_is_zero(c->direction)) {
            ecp_i_copy3(along, c->direction);
            axis = -1;
        }
        c->on_b->axis = axis;
    }
    ecp_i_scale(1 / c->c_norm, c->o, c->o);
    ecp_i_cross(c->o, c->N, c->t);
}

/* The point a, at the beginning of the step, from where the primitive of B is placed, which is at `origin` from B's
   centre of mass. */
static void ecp_i_from_b(const ecp_i_pair *c, ecp_real origin[3], ecp_real rel[3])
{
    ecp_i_mul(c->mb->R0, c->b->position, origin);
    ecp_i_add(c->offset, c->ra0, rel);
    ecp_i_sub(rel, origin, rel);
}

/* what counts for the rounding of a point at r from a body's centre of mass, and on a primitive of it: how far it is
   from there, or the primitive's own origin, where that is farther away */
static ecp_real ecp_i_arm(const ecp_i_part *part, const ecp_real r[3])
{
    return ecp_i_max(ecp_i_norm(r), ecp_i_norm(part->position));
}

/* The gap of a over the half-space {x : size.x <= size[3]} at the beginning of the step; zero when it
   is no more than its rounding error. */
static void ecp_i_plane_gap_before(ecp_i_pair *c)
{
    const ecp_real *size = c->b->shape.size;
    ecp_real origin[3], rel[3], local[3], arm = ecp_i_arm(c->a, c->ra0);
    ecp_i_from_b(c, origin, rel);
    ecp_i_mul(c->b->rotation, size, local);
    ecp_i_mul(c->mb->R0, local, c->N0);
    c->d0 = ecp_i_dot(c->N0, rel) - size[3];
    c->d_floor =
        ECP_I_EPSILON * (ecp_i_norm(c->offset) + arm + ecp_i_norm(origin) + ecp_i_abs(size[3]));
    c->d_noise = c->d_floor;
    if (ecp_i_abs(c->d0) <= c->d_floor / 2) c->d_noise = ECP_I_EPSILON * arm;
    if (ecp_i_abs(c->d0) <= c->d_floor) c->d0 = 0;
}

/* The same at the end: the former plus what the step adds to it, as the sum of the two positions would
   round the increment away. */
static ecp_real ecp_i_plane_gap_after(const ecp_i_pair *c)
{
    const ecp_i_motion *ma = c->ma, *mb = c->mb;
    ecp_real moved[3], d = c->d0;
    ecp_i_sub(ma->dx, mb->dx, moved);
    ecp_i_add(moved, c->turned, moved);
    if (mb->body->kind == ECP_KINEMATIC) {
        ecp_real origin[3], rel[3], turn[3];
        ecp_i_from_b(c, origin, rel);
        ecp_i_mul(mb->T, origin, turn);
        ecp_i_sub(moved, turn, moved);
        ecp_i_add(rel, moved, rel);
        ecp_i_mul(mb->T, c->N0, turn);
        d += ecp_i_dot(turn, rel);
    }
    return d + ecp_i_dot(c->N0, moved);
}

/* Does what was found `since` a body had turned so many times hold still? From now on it does. */
static int ecp_i_still_holds(int *since, const ecp_i_motion *m)
{
    int holds = ECP_I_FAST && *since == m->turns;
    if (ECP_I_FAST) *since = m->turns;
    return holds;
}

/* the rotation of B; the normal and the tangents of a half-space, which stay as they are in a step */
static void ecp_i_pair_turn_b(ecp_i_pair *c)
{
    if (ecp_i_still_holds(&c->turns_b, c->mb)) return;
    ecp_i_matmul(c->mb->R, c->b->rotation, c->Qb);
    if (!ecp_i_on_plane(c)) return;
    ecp_i_mul(c->Qb, c->b->shape.size, c->N);
    ecp_i_scale(-1, c->N, c->n);
    ecp_i_tangents(c);
}

/* What depends on the ECP a (in the frame of A) and not on the trial motion. Where a is the last one,
   as in the first residual after a start, nothing is to be done. */
static void ecp_i_pair_place(ecp_i_pair *c, const ecp_real a[3])
{
    ecp_real at[3];
    if (ECP_I_FAST) {
        if (c->placed && ecp_i_equal(a, c->a_local)) return;
        c->placed = 1;
        c->turns_a = 0;
    }
    ecp_i_copy3(a, c->a_local);
    c->a->shape.cls->eval(&c->a->shape, a, c->fa, c->ga);
    ecp_i_mul(c->a->rotation, a, at);
    ecp_i_add(at, c->a->position, at);
    ecp_i_mul(c->ma->R0, at, c->ra0);
    if (ecp_i_on_plane(c)) ecp_i_plane_gap_before(c);
}

/* In the relaxed problem the faces of A are slightly curved about its centre, by this much of the
   relaxation: the place of a pressure centre costs something then, and no constraint is without its
   compliance. More of it draws deep overlaps away from their solution. */
#define ECP_I_CURVED ECP_R(0.005)

/* sum l_i grad f_i */
static void ecp_i_pair_cone(ecp_i_pair *c, const ecp_real *y)
{
    ecp_real cone[3] = {0, 0, 0};
    int i;
    for (i = 0; i < c->nl; i++) ecp_i_axpy(cone, y[3 + i], c->ga + 3 * i, cone);
    if (ecp_i_relax(c) > 0) {
        ecp_i_axpy(cone, ECP_I_CURVED * ecp_i_relax(c), y, cone);
        ecp_i_axpy(cone, -ECP_I_CURVED * ecp_i_relax(c) / c->L, c->a->shape.centre, cone);
    }
    ecp_i_copy3(cone, c->cone);
}

/* the gap as its row has it */
static ecp_real ecp_i_row_gap(const ecp_i_pair *c)
{
    return ecp_i_on_plane(c) ? c->d : c->d - c->on_b->rest;
}

/* what adding up positions rounds in the gap of a pair whose ECP is seen from A at ra, from B at rb */
static ecp_real ecp_i_gap_rounding(const ecp_i_pair *c, const ecp_real ra[3], const ecp_real rb[3])
{
    return ECP_I_EPSILON * (ecp_i_norm(c->offset) + ecp_i_arm(c->a, ra) + ecp_i_arm(c->b, rb));
}

/* How many of these the gap of bodies that are posed flush is granted: rotations are rounded as well, and that moves
   every point. (Two cubes at the origin, in random poses, need up to 4.5: test_step_poses.) */
#define ECP_I_POSE_ROUNDING 6

/* N, and the rounding error of the gap, of a patch whose Qa, ra, rb are known */
static void ecp_i_pair_normal(ecp_i_pair *c, const ecp_real *y)
{
    ecp_i_pair_turn_b(c);
    if (ecp_i_on_plane(c)) return;
    ecp_i_pair_cone(c, y);
    ecp_i_mul(c->Qa, c->cone, c->n);
    ecp_i_scale(-1, c->n, c->N);
    c->d_floor = c->d_noise = ecp_i_gap_rounding(c, c->ra, c->rb);
}

/* after that: d, rb2, b with g there; the cone of a half-space's patch, which its normal does not need */
static void ecp_i_pair_gap(ecp_i_pair *c, const ecp_real *y, ecp_real h)
{
    ecp_i_side_b *b = c->on_b;
    ecp_real origin[3], at[3];
    c->d = ecp_i_on_plane(c) ? ecp_i_plane_gap_after(c) : h * c->V * y[ecp_i_at_d(c)];
    if (ecp_i_on_plane(c)) {
        ecp_i_pair_cone(c, y);
        return;
    }
    ecp_i_axpy(c->rb, c->d, c->n, b->rb2);
    ecp_i_mul(c->mb->R, c->b->position, origin);
    ecp_i_sub(b->rb2, origin, at);
    ecp_i_mul_t(c->Qb, at, b->b_local);
    c->b->shape.cls->eval(&c->b->shape, b->b_local, b->fb, b->gb);
}

/* |x|, smoothed by tau */
static ecp_real ecp_i_smooth_abs(ecp_real x, ecp_real tau2)
{
    return tau2 == 0 ? ecp_i_abs(x) : ecp_i_sqrt(x * x + tau2);
}

/* Where the patch is on A and its normal, from its unknowns y and the trial motion of the two bodies. */
static void ecp_i_pair_geometry(ecp_i_pair *c, const ecp_real *y)
{
    ecp_real a[3], moved[3];
    ecp_i_scale(c->L, y, a);
    ecp_i_pair_place(c, a);
    if (!ecp_i_still_holds(&c->turns_a, c->ma)) {
        ecp_i_matmul(c->ma->R, c->a->rotation, c->Qa);
        ecp_i_mul(c->ma->T, c->ra0, c->turned);
        ecp_i_add(c->turned, c->ra0, c->ra);
    }
    ecp_i_sub(c->ma->dx, c->mb->dx, moved);
    ecp_i_add(c->offset, moved, moved);
    ecp_i_add(moved, c->ra, c->rb);
    ecp_i_pair_normal(c, y);
}

/* The impulse on A, after the geometry and the tangents. */
static void ecp_i_pair_impulse(ecp_i_pair *c, const ecp_real *y)
{
    const ecp_real *p = y + ecp_i_at_p(c);
    ecp_i_copy(1 + ecp_i_nf(c), p, c->p);
    ecp_i_scale(c->P * p[0], c->N, c->force);
    if (ecp_i_nf(c) == 0) return;
    ecp_i_axpy(c->force, c->e[0] * c->P * p[1], c->t, c->force);
    ecp_i_axpy(c->force, c->e[1] * c->P * p[2], c->o, c->force);
}

/* the velocity of A relative to B at a, at the end of the step */
static void ecp_i_pair_velocity(const ecp_i_pair *c, ecp_real v[3])
{
    ecp_i_relative_velocity(c->ma->v, c->mb->v, c->ra, c->rb, v);
}

/* The velocity of A relative to B at a, and its spin: at the end of the step; or, along the chord, how
   far the step moves the point of A that is there then from that of B, over h. R0 R^T = (1 + T)^T, so
   B's has come from rb + T^T rb. */
static void ecp_i_pair_motion(ecp_i_pair *c)
{
    ecp_real carried[3];
    ecp_i_sub(c->ma->v + 3, c->mb->v + 3, c->spin);
    if (ecp_i_chord(c) > 0) {
        ecp_i_sub(c->ma->dx, c->mb->dx, c->v);
        ecp_i_add(c->v, c->turned, c->v);
        ecp_i_mul_t(c->mb->T, c->rb, carried);
        ecp_i_add(c->v, carried, c->v);
        ecp_i_scale(1 / ecp_i_chord(c), c->v, c->v);
        return;
    }
    ecp_i_pair_velocity(c, c->v);
}

/* What the friction rows oppose: w = (e_t v_t, e_o v_o, e_r w_n) in units V; in a relaxed problem also a
   share of the impulse. */
static void ecp_i_pair_slip(ecp_i_pair *c)
{
    int k;
    ecp_i_set3(c->e[0] * ecp_i_dot(c->t, c->v), c->e[1] * ecp_i_dot(c->o, c->v),
               ecp_i_nf(c) == 3 ? c->e[2] * ecp_i_dot(c->N, c->spin) : ECP_R(0), c->slip);
    for (k = 0; k < ecp_i_nf(c); k++) c->slip[k] = c->slip[k] / c->V + ecp_i_relax(c) * c->p[1 + k];
}

/* Everything that the residual and its derivative need. */
static void ecp_i_pair_evaluate(ecp_i_pair *c, const ecp_real *y, ecp_real h)
{
    ecp_i_pair_geometry(c, y);
    ecp_i_pair_gap(c, y, h);
    if (ecp_i_nf(c) > 0 && !ecp_i_on_plane(c)) ecp_i_tangents(c);
    ecp_i_pair_impulse(c, y);
    if (ECP_I_FRICTION) ecp_i_pair_motion(c);
    if (ecp_i_nf(c) > 0) ecp_i_pair_slip(c);
}

/* the moment impulse on A about the normal */
static ecp_real ecp_i_torsion(const ecp_i_pair *c)
{
    return ecp_i_nf(c) == 3 ? c->e[2] * c->P * c->p[3] : ECP_R(0);
}

/* the size of the patch's impulse, whatever cancels in it */
static ecp_real ecp_i_impulse_size(const ecp_i_pair *c)
{
    ecp_real size = c->P * ecp_i_abs(c->p[0]);
    int k;
    for (k = 1; k <= ecp_i_nf(c) && k < 3; k++) size += ecp_i_abs(c->e[k - 1] * c->P * c->p[k]);
    return size + ecp_i_abs(ecp_i_torsion(c)) / c->L;
}

/* takes the patch's wrench, `sign` on this body, off its momentum balance, and counts it in the floors */
static void ecp_i_wrench(const ecp_i_pair *c, ecp_i_motion *m, const ecp_real r[3], ecp_real sign)
{
    ecp_real moment[3], size = ecp_i_impulse_size(c);
    ecp_i_scale(ecp_i_torsion(c), c->N, moment);
    ecp_i_add_cross(r, c->force, moment);
    ecp_i_axpy(m->residual, -sign, c->force, m->residual);
    ecp_i_axpy(m->residual + 3, -sign, moment, m->residual + 3);
    m->floor[0] += size;
    m->floor[1] += size * ecp_i_norm(r);
}

/* rows of multipliers l of inequalities f, unit times which is the slack; most of them are off */
static void ecp_i_multiplier_rows(int count, const ecp_real *l, const ecp_real *f, ecp_real unit,
                                  ecp_real tau, ecp_real *F)
{
    ecp_real r;
    int i;
    for (i = 0; i < count; i++) {
        ecp_real slack = unit * f[i];
        F[i] = 0;
        if (ECP_I_FAST && l[i] == 0 && slack > 0 && tau == 0) continue;
        F[i] = ecp_i_fb_value(l[i], slack, tau, &r);
    }
}

/* rho of the friction rows at least, relative to the rho with which their error is measured, and whether
   it goes by the lighter body: in single precision it can not go low enough for that to help */
#ifdef ECPSIM_FLOAT
#define ECP_I_LEAST_RHO (ECP_R(1.0) / 1024)
#define ECP_I_RHO_OF_MASS 0
#else
#define ECP_I_LEAST_RHO (ECP_R(1.0) / 1048576)
#define ECP_I_RHO_OF_MASS ECP_I_PAIRS
#endif

/* rho of the friction rows of F. No solution of the true problem depends on rho, but Newton takes a contact
   to stick where rho slip is within mu p_n. Where the load is light beside the momenta in play, or one of
   the bodies is beside the load, that is so little slip that it does not find from slipping to sticking: rho
   is not more than the load, nor than the lighter body's mass in the same units. */
static ecp_real ecp_i_rho(const ecp_i_pair *c)
{
    ecp_real most = ecp_i_norm(c->weight), mass = c->carried->mass;
    if (ecp_i_moves_a(c) && ecp_i_moves_b(c)) mass = ecp_i_min(c->ma->mass, c->mb->mass);
    if (ECP_I_RHO_OF_MASS) most = ecp_i_min(most, mass * c->V / c->P);
    most = ecp_i_max(most, ECP_I_LEAST_RHO * c->rho);
    return ecp_i_relax(c) > 0 ? c->rho : ecp_i_min(c->rho, most);
}

/* z = y - rho slip, projected on the ball of the radius mu p_n: to z radius / outer with
   outer = max(|z|, radius), where |z|, the positive part of p_n and the maximum are smoothed by tau; taken: the part
   of z that this takes away */
typedef struct ecp_i_projection {
    ecp_real rho, z[3], z_norm, radius, outer, taken;
} ecp_i_projection;

static void ecp_i_cone_project(const ecp_i_pair *c, ecp_real rho, ecp_i_projection *q)
{
    ecp_real tau2 = ecp_i_relax(c) * ecp_i_relax(c), sum = tau2;
    int k;
    q->rho = rho;
    for (k = 0; k < ecp_i_nf(c); k++) {
        q->z[k] = c->p[1 + k] - rho * c->slip[k];
        sum += q->z[k] * q->z[k];
    }
    q->z_norm = ecp_i_sqrt(sum);
    q->radius = c->mu * (c->p[0] + ecp_i_smooth_abs(c->p[0], tau2)) / 2;
    q->outer = (q->z_norm + q->radius + ecp_i_smooth_abs(q->z_norm - q->radius, tau2)) / 2;
    q->taken = q->outer > q->radius ? (q->outer - q->radius) / q->outer : ECP_R(0);
}

/* The friction rows y - s z with s = radius / outer, written as (1 - s) y + s rho slip, which is as exact
   as the slip is, however small rho. */
static void ecp_i_friction_rows(const ecp_i_pair *c, const ecp_i_projection *q, ecp_real *F)
{
    ecp_real s = q->taken > 0 ? q->radius / q->outer : ECP_R(1);
    int k;
    for (k = 0; k < ecp_i_nf(c); k++) F[k] = q->taken * c->p[1 + k] + s * q->rho * c->slip[k];
}

/* The patch's rows of F, after ecp_i_pair_evaluate. */
static void ecp_i_pair_residual(const ecp_i_pair *c, const ecp_real *y, ecp_real h, ecp_real *F)
{
    ecp_real r, local[3], unit = -1 / c->L;
    ecp_i_projection q;
    int i, row;
    ecp_i_mul_t(ecp_i_on_plane(c) ? c->Qa : c->Qb, c->n, local);
    if (ecp_i_on_plane(c)) {
        ecp_i_sub(c->cone, local, F);
    } else {
        F[0] = (ecp_i_dot(c->n, c->n) - 1) / 2;
        for (i = 0; i < c->nm; i++) {
            ecp_i_axpy(local, y[ecp_i_at_m(c) + i], c->on_b->gb + 3 * i, local);
        }
        ecp_i_copy3(local, F + 1);
    }
    row = ecp_i_on_plane(c) ? 3 : 4;
    ecp_i_multiplier_rows(c->nl, y + 3, c->fa, unit, ecp_i_relax(c), F + row);
    row += c->nl;
    if (!ecp_i_on_plane(c)) {
        ecp_i_multiplier_rows(c->nm, y + ecp_i_at_m(c), c->on_b->fb, unit, ecp_i_relax(c), F + row);
        row += c->nm;
    }
    F[row++] = ecp_i_fb_value(c->p[0], ecp_i_row_gap(c) / (h * c->V) + ecp_i_relax(c) * c->p[0],
                              ecp_i_relax(c), &r);
    if (ecp_i_nf(c) == 0) return;
    ecp_i_cone_project(c, ecp_i_rho(c), &q);
    ecp_i_friction_rows(c, &q, F + row);
}

/* >>jacobian: one column for each unknown, by carrying a first-order change through the rows */

typedef struct ecp_i_change {
    ecp_real ra[3], rb[3];  /* of the point a, seen from A and from B */
    ecp_real n[3];          /* of the outward normal of A (pair) */
    ecp_real rows[3];       /* direct change of the three rows of the normal */
    ecp_real d;             /* of the gap (pair) */
    ecp_real turn_b[3];     /* rotation of B */
    ecp_real v[3], spin[3]; /* which only friction asks for */
    ecp_real p[4];          /* of p_n / P and y */
} ecp_i_change;

/* the change of b = Qb^T (a2 - x_B), in lengths L */
static void ecp_i_change_of_b(const ecp_i_pair *c, const ecp_i_change *t, ecp_real db[3])
{
    ecp_real moved[3], turned[3];
    ecp_i_axpy(t->rb, t->d, c->n, moved);
    ecp_i_axpy(moved, c->d, t->n, moved);
    ecp_i_cross(c->on_b->rb2, t->turn_b, turned);
    ecp_i_add(moved, turned, moved);
    ecp_i_mul_t(c->Qb, moved, db);
    ecp_i_scale(1 / c->L, db, db);
}

/* rows of a pair's geometry: |n|, Qb^T n + sum m grad g(b), and the active multipliers of g */
static int ecp_i_pair_column(const ecp_i_pair *c, const ecp_i_change *t, ecp_real *column)
{
    ecp_real local[3] = {0, 0, 0}, db[3], turned[3];
    int i, k, ld = c->columns, row = 0;
    column[ld * row++] = ecp_i_dot(c->n, t->n);
    ecp_i_change_of_b(c, t, db);
    if (!ecp_i_is_zero(t->n) || !ecp_i_is_zero(t->turn_b)) {
        ecp_i_cross(c->n, t->turn_b, turned);
        ecp_i_add(turned, t->n, turned);
        ecp_i_mul_t(c->Qb, turned, local);
    }
    ecp_i_mul(c->on_b->Hb, db, turned);
    for (k = 0; k < 3; k++) column[ld * row++] = local[k] + turned[k] + t->rows[k];
    row += c->kl;
    for (i = 0; i < c->km; i++) {
        int j = c->on_b->active_b[i];
        column[ld * row++] = -c->on_b->slope_b[j] * ecp_i_dot(c->on_b->gb + 3 * j, db);
    }
    return row;
}

/* how near to its kink a row may be treated as on either side */
static ecp_real ecp_i_kink(int centring) { return centring ? ecp_i_sqrt(ECP_I_EPSILON) : ECP_R(0); }

/* what the columns of one block have in common: the slopes of the gap's row by p_n and by the gap; the
   projection, the part of z that it takes away and, unless that is nothing, the slopes of outer by |z| and
   of the radius by p_n */
typedef struct ecp_i_slopes {
    ecp_real p, d, rest, outer, radius;
    int on_limit;            /* are the friction rows those of the ball's surface? */
    ecp_real on, on_a, on_b; /* momentum for an impulse on A: shared (ecp_i_seat), of A, of B */
    ecp_i_projection cone;
} ecp_i_slopes;

static void ecp_i_pair_slopes(ecp_i_pair *c, ecp_real h, ecp_real kink, ecp_i_slopes *s)
{
    ecp_real apart, tau2 = ecp_i_relax(c) * ecp_i_relax(c), p = c->p[0], q, size;
    ecp_real d = ecp_i_row_gap(c);
    int idles = ECP_I_CENTRING && ecp_i_abs(p) < kink && ecp_i_abs(d) < kink * h * c->V;
    ecp_i_fb(p, d / (h * c->V) + ecp_i_relax(c) * p, ecp_i_relax(c), &s->p, &s->d);
    if (idles) {
        /* centring: a contact that touches without a load may take one, or stays so, as the patch is told */
        s->p = c->open;
        s->d = 1 - s->p;
    }
    if (ecp_i_moves_a(c)) s->on_a = -1 / (c->ma->mass * c->ma->speed);
    if (ecp_i_moves_b(c)) s->on_b = 1 / (c->mb->mass * c->mb->speed);
    if (ECP_I_PAIRS) s->on = ecp_i_moves_a(c) ? s->on_a : s->on_b;
    if (ecp_i_moves_a(c) && ecp_i_moves_b(c)) s->on = ecp_i_min(s->on_a, -s->on_b);
    s->rest = 0;
    s->on_limit = 0;
    if (ecp_i_nf(c) == 0) return;
    ecp_i_cone_project(c, ecp_i_rho(c), &s->cone);
    s->rest = s->cone.taken;
    if (idles && c->open) {
        /* without an impulse there is no friction */
        s->rest = s->outer = 1;
        s->on_limit = 1;
        s->radius = 0;
        c->may_stick = 0;
        return;
    }
    c->may_stick = s->rest < kink || (idles && ecp_i_norm(c->slip) < kink);
    if (ECP_I_CENTRING && c->may_stick) {
        /* centring: friction at its limit that does not slip leaves it or stays there, as the patch is told, and where
           there is no load it grows with that */
        s->rest = 0;
        s->outer = 1;
        s->radius = c->mu;
        s->on_limit = c->held;
        return;
    }
    s->on_limit = s->rest > 0;
    if (!s->on_limit) return;
    apart = s->cone.z_norm - s->cone.radius;
    q = ecp_i_smooth_abs(apart, tau2);
    size = ecp_i_smooth_abs(p, tau2);
    s->outer = (1 + apart / q) / 2;
    s->radius = c->mu * (size > 0 ? (1 + p / size) / 2 : ECP_R(1));
}

/* friction rows: y - P(z) with P = radius z / outer. Without smoothing that is dP = dz inside the
   cone, and (radius / |z|) (dz - u u.dz) + u d radius with u = z / |z| outside. dw: the change of the
   slip (t.v, o.v, N.spin) */
static void ecp_i_friction_column(const ecp_i_pair *c, const ecp_i_slopes *s, const ecp_i_change *t,
                                  const ecp_real dw[3], ecp_real *column)
{
    const ecp_i_projection *q = &s->cone;
    ecp_real along = 0, shrink = 1 - s->rest, grows;
    int k, ld = c->columns;
    for (k = 0; k < ecp_i_nf(c); k++) {
        ecp_real give = (ecp_i_relax(c) + c->compliance) * t->p[1 + k];
        column[ld * k] = q->rho * (c->e[k] * dw[k] / c->V + give);
        along += q->z[k] * (t->p[1 + k] - column[ld * k]);
    }
    if (!s->on_limit) return;
    /* dP = s dz + z grows with s = radius / outer, so grows = (d radius - s d outer) / outer */
    grows = ((1 - shrink * (1 - s->outer)) * s->radius * t->p[0] -
             shrink * s->outer * along / q->z_norm) /
            q->outer;
    for (k = 0; k < ecp_i_nf(c); k++) {
        column[ld * k] = s->rest * t->p[1 + k] + shrink * column[ld * k] - q->z[k] * grows;
    }
}

/* the rows of one body's angular momentum, in units of m vs L; scale: 1 / (m vs), negative on A */
static void ecp_i_moment_column(const ecp_i_pair *c, const ecp_i_motion *m, ecp_real scale,
                                const ecp_real r[3], const ecp_real dr[3], const ecp_real dF[3],
                                const ecp_real twist[3], ecp_real *column)
{
    ecp_real moment[3];
    int k, ld = c->columns, pushes = !ECP_I_FAST || !ecp_i_is_zero(dF);
    if (!pushes && ecp_i_is_zero(dr) && ecp_i_is_zero(twist)) return;
    ecp_i_cross(dr, c->force, moment);
    ecp_i_add(moment, twist, moment);
    if (pushes) ecp_i_add_cross(r, dF, moment);
    scale /= m->length;
    for (k = 0; k < 3; k++) column[ld * k] = scale * moment[k];
}

/* One column of the patch's block, zero before: how its rows, and the bodies' momentum rows below
   them, change under t. The rows of the active multipliers of f, and each multiplier's entry
   in its own row, are written by the caller. Most changes leave most of it alone: multipliers move
   nothing, impulses turn nothing, and only a pair's normal changes. */
static void ecp_i_column(const ecp_i_pair *c, const ecp_i_slopes *s, const ecp_i_change *t,
                         ecp_real h, ecp_real *column)
{
    ecp_real dN[3] = {0, 0, 0}, d_o[3] = {0, 0, 0}, dt[3] = {0, 0, 0}, dF[3] = {0, 0, 0},
             dw[3] = {0, 0, 0};
    ecp_real twist[3] = {0, 0, 0}, d = t->d;
    int k, ld = c->columns, row = 3 + c->kl, pair = !ecp_i_on_plane(c);
    int turns = pair && !ecp_i_is_zero(t->n);
    int pushes = !ECP_I_FAST || t->p[0] != 0 || !ecp_i_is_zero(t->p + 1);
    int slides = ECP_I_FRICTION && !(ecp_i_is_zero(t->v) && ecp_i_is_zero(t->spin));
    int moves = !ECP_I_FAST || turns || slides || d != 0 || !ecp_i_is_zero(t->rb) ||
                !ecp_i_is_zero(t->ra) || (pair && !ecp_i_is_zero(t->turn_b));
    if (!pair) {
        for (k = 0; k < 3; k++) column[ld * k] = t->rows[k];
        d = ecp_i_dot(c->N, t->rb);
    } else if (moves) {
        row = ecp_i_pair_column(c, t, column);
    } else {
        for (k = 0; k < 3; k++) column[ld * (1 + k)] = t->rows[k];
        row += 1 + c->km;
    }
    if (!moves && !pushes) return;
    column[ld * row++] =
        s->p * t->p[0] + s->d * (d / (h * c->V) + (ecp_i_relax(c) + c->compliance) * t->p[0]);
    if (moves && ecp_i_nf(c) > 0) {
        dw[0] = ecp_i_dot(c->t, t->v);
        dw[1] = ecp_i_dot(c->o, t->v);
        dw[2] = ecp_i_dot(c->N, t->spin);
    }
    if (turns) ecp_i_scale(-1, t->n, dN);
    if (turns && ecp_i_nf(c) > 0) {
        ecp_i_cross(dN, c->on_b->along, d_o);
        ecp_i_axpy(d_o, -ecp_i_dot(c->o, d_o), c->o, d_o);
        ecp_i_scale(1 / c->c_norm, d_o, d_o);
        ecp_i_cross(d_o, c->N, dt);
        ecp_i_add_cross(c->o, dN, dt);
        dw[0] += ecp_i_dot(dt, c->v);
        dw[1] += ecp_i_dot(d_o, c->v);
        dw[2] += ecp_i_dot(dN, c->spin);
    }
    if (ecp_i_nf(c) > 0) ecp_i_friction_column(c, s, t, dw, column + ld * row);
    row += ecp_i_nf(c);
    if (pushes) ecp_i_scale(c->P * t->p[0], c->N, dF);
    if (turns) ecp_i_axpy(dF, c->P * c->p[0], dN, dF);
    if (ecp_i_nf(c) > 0) {
        if (pushes) ecp_i_axpy(dF, c->e[0] * c->P * t->p[1], c->t, dF);
        if (turns) ecp_i_axpy(dF, c->e[0] * c->P * c->p[1], dt, dF);
        if (pushes) ecp_i_axpy(dF, c->e[1] * c->P * t->p[2], c->o, dF);
        if (turns) ecp_i_axpy(dF, c->e[1] * c->P * c->p[2], d_o, dF);
    }
    if (ecp_i_nf(c) == 3) {
        if (pushes) ecp_i_scale(c->e[2] * c->P * t->p[3], c->N, twist);
        if (turns) ecp_i_axpy(twist, ecp_i_torsion(c), dN, twist);
    }
    column += ld * row;
    for (k = 0; (pushes || turns) && k < 3; k++) {
        column[ld * k] = (ECP_I_PAIRS ? s->on : s->on_a) * dF[k];
    }
    column += 3 * ld;
    if (ecp_i_moves_a(c)) {
        ecp_i_moment_column(c, c->ma, s->on_a, c->ra, t->ra, dF, twist, column);
        column += 3 * ld;
    }
    if (ecp_i_moves_b(c)) {
        ecp_i_moment_column(c, c->mb, s->on_b, c->rb, t->rb, dF, twist, column);
    }
}

/* A multiplier l against its slack s as a Newton step takes it, which is not as F has it. l turns the normal, and a
   step of the world turns it by about `tilt`, 1e-5 for a box at rest; s is where the ECP is, of the order of one.
   Fischer-Burmeister of l and tilt s has the same zeros, and slopes by which l goes to nothing while the ECP crosses
   its face. By the slopes of F the ECP would creep, in each iteration by as much as l is off. A multiplier that is
   rounding does not hold an ECP on the rim. */
static ecp_real ecp_i_multiplier_row(ecp_real l, ecp_real s, ecp_real tilt, ecp_real tau,
                                     ecp_real *da, ecp_real *db)
{
    ecp_real b = tilt * s, F = ecp_i_fb(l, b, tau, da, db);
    if (tilt < 1 && l > 0 && b < 0) F = ecp_i_fb_mixed(b, l, tau);
    if (tilt < 1 && ecp_i_abs(l) <= 4 * ECP_I_EPSILON) ecp_i_fb(0, b, tau, da, db);
    *db *= tilt;
    return F;
}

/* Multipliers whose row is steeper in l than in the constraint, dF = da dl + db ds with da >= db,
   are eliminated at once: dl_i = fixed_i + slope_i g_i.da; they add slope_i g_i g_i^T to the Hessian
   H and sum_i fixed_i g_i to the cone (ecp_i_shift). The others are listed in active[], with fixed =
   da and slope = db, over tilt. Returns their number. At the kink (both l and f within `kink` of zero) the
   constraint counts as off, which is one of the generalised derivatives: an ECP on the rim of its patch can
   leave it. */
static int ecp_i_condense(int count, const ecp_real *l, const ecp_real *f, const ecp_real *g,
                          ecp_real L, ecp_real tilt, ecp_real tau, ecp_real kink, ecp_real *fixed,
                          ecp_real *slope, int *active, ecp_real H[9])
{
    int i, j, k, kept = 0;
    for (i = 0; i < count; i++) {
        ecp_real da, db, F = ecp_i_multiplier_row(l[i], -f[i] / L, tilt, tau, &da, &db);
        if (!(tau > 0) && ecp_i_abs(l[i]) <= kink && ecp_i_abs(f[i]) <= kink * L) {
            da = 1;
            db = 0;
        }
        if (da < db) {
            fixed[i] = da / tilt;
            slope[i] = db / tilt;
            active[kept++] = i;
            continue;
        }
        fixed[i] = -F / da;
        slope[i] = db / da;
        for (j = 0; slope[i] > 0 && j < 3; j++) {
            for (k = 0; k < 3; k++) H[3 * j + k] += slope[i] * g[3 * i + j] * g[3 * i + k];
        }
    }
    return kept;
}

/* sum_i fixed_i g_i over the multipliers that are eliminated at once: all but the active ones */
static void ecp_i_shift(int count, const ecp_real *g, const ecp_real *fixed, int kept,
                        const int *active, ecp_real shift[3])
{
    int i, k = 0;
    ecp_i_set3(0, 0, 0, shift);
    for (i = 0; i < count; i++) {
        if (k < kept && active[k] == i)
            k++;
        else
            ecp_i_axpy(shift, fixed[i], g + 3 * i, shift);
    }
}

static void ecp_i_hessian(const ecp_shape *s, const ecp_real x[3], const ecp_real *l, ecp_real L,
                          ecp_real H[9])
{
    int k;
    ECPSIM_MEMSET(H, 0, 9 * sizeof(ecp_real));
    if (!s->cls->hess) return;
    s->cls->hess(s, x, l, H);
    for (k = 0; k < 9; k++) H[k] *= L;
}
/* >>elimination ===========================================================================
   A Newton step J dz = -F of an island. Each patch's unknowns are eliminated by themselves, with
   complete pivoting, in its block

       [ own rows     x own unknowns | velocities of A and B | right-hand side ]
       [ momentum rows of A and B                                              ]

   (of the linear ones, which A and B share, only one set: ecp_i_seat).

   What cannot be pivoted there (the tangential place of an ECP on a face, impulses of a closed
   contact: the block is singular in ordinary states) is passed on to the bodies' front, where the
   rows that are left constrain the velocities and the unknowns that are left are forces:

       [ M  B ] [ dv ]   [ b ]
       [ C  0 ] [ dx ] = [ c ]                                                             */

/* unknowns of geometry move ECPs, those of impulse do not: the least step counts them differently */
enum { ECP_I_GEOMETRY = 1, ECP_I_IMPULSE = 2, ECP_I_LAST = 4, ECP_I_GAP = 8 };

/* what is not larger is rounding error, and no pivot */
#define ECP_I_NO_PIVOT (256 * ECP_I_EPSILON)

/* how much dearer moving an ECP by L is than changing an impulse by its unit */
#define ECP_I_ECP_WEIGHT ECP_R(100.0)

/* adds T^T of the turn of a body times dr, over h, to the change of a velocity along the chord */
static void ecp_i_add_turned_back(const ecp_i_pair *c, const ecp_i_motion *m, ecp_real sign,
                                  const ecp_real dr[3], ecp_real v[3])
{
    ecp_real back[3];
    ecp_i_mul_t(m->T, dr, back);
    ecp_i_axpy(v, sign / ecp_i_chord(c), back, v);
}

/* a change of the cone sum l_i grad f_i, in the frame of A */
static void ecp_i_change_cone(const ecp_i_pair *c, const ecp_real dcone[3], ecp_i_change *t)
{
    ecp_real turned[3];
    if (ecp_i_on_plane(c)) {
        ecp_i_add(t->rows, dcone, t->rows);
    } else {
        ecp_i_mul(c->Qa, dcone, turned);
        ecp_i_add(t->n, turned, t->n);
    }
}

static void ecp_i_change_ecp(const ecp_i_pair *c, const ecp_real da[3], ecp_i_change *t)
{
    ecp_real dr[3], dcone[3];
    ecp_i_mul(c->Qa, da, dr);
    ecp_i_scale(c->L, dr, dr);
    ecp_i_add(t->ra, dr, t->ra);
    ecp_i_add(t->rb, dr, t->rb);
    if (ecp_i_chord(c) > 0) {
        ecp_i_add_turned_back(c, c->mb, 1, dr, t->v);
        ecp_i_add_turned_back(c, c->ma, -1, dr, t->v);
    } else if (ECP_I_FRICTION) {
        ecp_i_add_cross(c->spin, dr, t->v);
    }
    ecp_i_mul(c->Ha, da, dcone);
    ecp_i_change_cone(c, dcone, t);
}

/* The compliance against moments: where the pressure centre moves by da, the faces part on the other
   side. */
static void ecp_i_change_tilt(const ecp_i_pair *c, const ecp_real da[3], ecp_i_change *t)
{
    ecp_real turned[3], local[3];
    if (ecp_i_on_plane(c)) {
        ecp_i_axpy(t->rows, c->compliance, da, t->rows);
    } else {
        ecp_i_mul(c->Qa, da, turned);
        ecp_i_mul_t(c->Qb, turned, local);
        ecp_i_axpy(t->rows, c->compliance, local, t->rows);
    }
}

/* dv: a scaled velocity change of one of the two bodies */
static void ecp_i_change_motion(const ecp_i_pair *c, const ecp_i_motion *m, ecp_real h,
                                const ecp_real dv[6], ecp_i_change *t)
{
    ecp_real w[3], turn[3], dr[3], local[3], u[3];
    ecp_real sign = m == c->ma ? ECP_R(1) : ECP_R(-1);
    int of_a = !ECP_I_PAIRS || m == c->ma;
    if (ECP_I_PAIRS && ecp_i_chord(c) == 0 && ecp_i_is_zero(dv + 3)) {
        /* nothing turns */
        ecp_i_axpy(t->v, sign * m->speed, dv, t->v);
        ecp_i_scale(sign * h * m->speed, dv, dr);
        ecp_i_add(t->rb, dr, t->rb);
        ecp_i_add_cross(dr, c->mb->v + 3, t->v);
        return;
    }
    ecp_i_scale(m->speed / m->length, dv + 3, w);
    ecp_i_mul(m->J, w, turn);
    if (ECP_I_FRICTION) ecp_i_axpy(t->spin, sign, w, t->spin);
    ecp_i_scale(sign * h * m->speed, dv, dr); /* of x_A - x_B */
    if (of_a) {
        ecp_i_cross(turn, c->ra, u);
        ecp_i_add(t->ra, u, t->ra);
        ecp_i_add(dr, u, dr);
    }
    ecp_i_add(t->rb, dr, t->rb);
    if (ecp_i_chord(c) > 0) {
        if (!of_a) ecp_i_add_cross(c->rb, turn, dr);
        ecp_i_axpy(t->v, 1 / h, dr, t->v);
        ecp_i_add_turned_back(c, c->mb, 1, dr, t->v);
    } else if (ECP_I_FRICTION) {
        ecp_i_axpy(t->v, sign * m->speed, dv, t->v);
        if (of_a) {
            ecp_i_add_cross(w, c->ra, t->v);
            ecp_i_add_cross(c->ma->v + 3, u, t->v);
        } else {
            ecp_i_add_cross(c->rb, w, t->v);
        }
        ecp_i_add_cross(dr, c->mb->v + 3, t->v);
    }
    if (!of_a) {
        ecp_i_add(t->turn_b, turn, t->turn_b);
        return;
    }
    ecp_i_cross(turn, c->n, u);
    if (ecp_i_on_plane(c)) {
        ecp_i_mul_t(c->Qa, u, local);
        ecp_i_add(t->rows, local, t->rows);
    } else {
        ecp_i_add(t->n, u, t->n);
    }
}

/* Where a velocity and a momentum of the bodies of a patch stand in its block. Two bodies share the places of the
   linear ones, as a patch sees only how A moves relative to B, and pushes both alike: the columns are those
   of A's velocities less B's, the rows the momentum that A gets, in units of the lighter body. */
typedef struct ecp_i_seat {
    int at, of;           /* row and column of the block, after its own; which velocity that is */
    ecp_real sees, takes; /* this velocity's column is the block's times the first, this momentum's
                             row the block's times the second */
} ecp_i_seat;

/* how many velocities and momenta a block of so many bodies has; of a patch's */
static int ecp_i_seats_of(int bodies) { return 3 + 3 * bodies; }
static int ecp_i_seats(const ecp_i_pair *c)
{
    return ecp_i_seats_of(ecp_i_moves_a(c) + ecp_i_moves_b(c));
}

/* that of velocity i of A (side 0) or B, which has this number */
static ecp_i_seat ecp_i_seat_of(const ecp_i_pair *c, int side, int i, int number)
{
    ecp_i_seat s;
    s.at = i;
    s.of = number;
    s.sees = s.takes = 1;
    if (!ecp_i_moves_a(c) || !ecp_i_moves_b(c)) return s;
    if (i < 3) {
        s.sees = side ? ECP_R(-1) : ECP_R(1);
        s.takes = s.sees * (ecp_i_min(c->ma->mass, c->mb->mass) / (side ? c->mb : c->ma)->mass);
    } else if (side) {
        s.at += 3;
    }
    return s;
}

/* All of them, those of A from number `a` on, those of B from number `b` on. Returns how many there are. */
static int ecp_i_seat_all(const ecp_i_pair *c, int a, int b, ecp_i_seat seats[12])
{
    int i, count = 0;
    for (i = 0; ecp_i_moves_a(c) && i < 6; i++) seats[count++] = ecp_i_seat_of(c, 0, i, a + i);
    for (i = 0; ecp_i_moves_b(c) && i < 6; i++) seats[count++] = ecp_i_seat_of(c, 1, i, b + i);
    return count;
}

/* column number k of the block, how it changes under t, which is nothing again afterwards */
static void ecp_i_block_column(const ecp_i_pair *c, const ecp_i_slopes *s, ecp_real h, int k,
                               ecp_i_change *t)
{
    ecp_i_column(c, s, t, h, c->block + k);
    ECPSIM_MEMSET(t, 0, sizeof *t);
}

/* one column for each own unknown and each velocity of a dynamic body */
static void ecp_i_block_columns(ecp_i_pair *c, const ecp_i_slopes *s, ecp_real h)
{
    ecp_i_change t;
    int i, k, side, column = 0, first = ecp_i_on_plane(c) ? 3 : 4, ld = c->columns;
    ECPSIM_MEMSET(&t, 0, sizeof t);
    for (k = 0; k < 3; k++, column++) {
        ecp_real unit[3] = {0, 0, 0};
        unit[k] = 1;
        ecp_i_change_ecp(c, unit, &t);
        if (c->compliance > 0) ecp_i_change_tilt(c, unit, &t);
        ecp_i_block_column(c, s, h, column, &t);
        for (i = 0; i < c->kl; i++) {
            int j = c->active_a[i];
            c->block[ld * (first + i) + column] = -c->slope_a[j] * c->ga[3 * j + k];
        }
    }
    for (i = 0; i < c->kl; i++, column++) {
        ecp_i_change_cone(c, c->ga + 3 * c->active_a[i], &t);
        ecp_i_block_column(c, s, h, column, &t);
        c->block[ld * (first + i) + column] = c->fixed_a[c->active_a[i]];
    }
    if (!ecp_i_on_plane(c)) {
        t.d = h * c->V;
        ecp_i_block_column(c, s, h, column++, &t);
    }
    for (i = 0; i < ecp_i_km(c); i++, column++) {
        ecp_i_copy3(c->on_b->gb + 3 * c->on_b->active_b[i], t.rows);
        ecp_i_block_column(c, s, h, column, &t);
        c->block[ld * (first + c->kl + i) + column] += c->on_b->fixed_b[c->on_b->active_b[i]];
    }
    for (i = 0; i <= ecp_i_nf(c); i++, column++) {
        t.p[i] = 1;
        ecp_i_block_column(c, s, h, column, &t);
    }
    for (side = 0; side < ECP_I_MOVERS; side++) {
        const ecp_i_motion *m = side ? c->mb : c->ma;
        if (!(side ? ecp_i_moves_b(c) : ecp_i_moves_a(c))) continue;
        for (i = side && ecp_i_moves_a(c) ? 3 : 0; i < 6; i++, column++) {
            ecp_real unit[6] = {0, 0, 0, 0, 0, 0};
            unit[i] = 1;
            ecp_i_change_motion(c, m, h, unit, &t);
            ecp_i_block_column(c, s, h, column, &t);
        }
    }
}

/* The displacement that the rule ECP_CENTRED would like, in the patch's unknowns: the ECP to the
   primitive's centre, of two to that of the smaller one (of a floor that is a box no load reaches it), impulses to
   zero. */
static void ecp_i_target(const ecp_i_pair *c, const ecp_real *y, ecp_real da[3], ecp_real dp[4])
{
    ecp_real at[3], world[3];
    int k;
    for (k = 0; k < 3; k++) da[k] = c->a->shape.centre[k] / c->L - y[k];
    for (k = 0; k <= ecp_i_nf(c); k++) dp[k] = -c->p[k];
    if (ecp_i_on_plane(c) || !(c->b->shape.radius < c->a->shape.radius)) return;
    ecp_i_sub(c->b->shape.centre, c->on_b->b_local, at);
    ecp_i_mul(c->Qb, at, world);
    ecp_i_mul_t(c->Qa, world, at);
    ecp_i_scale(1 / c->L, at, da);
}

/* What the rounding of the coordinates x, each its own, does to a normal with this Hessian: much at a
   sharp tip; along a needle's side little, as where it is curved it is thin. */
static ecp_real ecp_i_normal_noise(const ecp_real H[9], const ecp_real x[3])
{
    ecp_real most = 0;
    int i, j;
    for (i = 0; i < 3; i++) {
        ecp_real size = 0;
        for (j = 0; j < 3; j++) size += ecp_i_abs(H[3 * i + j] * x[j]);
        most = ecp_i_max(most, size);
    }
    return 2 * ECP_I_EPSILON * most;
}

/* And what the multipliers' rounding does to it, where they are large and their gradients cancel: at the
   edge of a sharp wedge they are one over its angle. Of others it is no more than of n itself. */
static ecp_real ecp_i_cone_noise(int count, const ecp_real *l)
{
    ecp_real sum = 0;
    int i;
    for (i = 0; i < count; i++) sum += ecp_i_abs(l[i]);
    return 4 * ECP_I_EPSILON * ecp_i_max(sum - 4, 0);
}

/* At the point of the last evaluation: the Hessians, which multipliers are kept, and how large the
   block is with these. */
static void ecp_i_block_condense(ecp_i_pair *c, const ecp_real *y, int centring)
{
    ecp_real b[3], kink = ecp_i_kink(centring);
    int i;
    ecp_i_hessian(&c->a->shape, c->a_local, y + 3, c->L, c->Ha);
    c->n_noise = ecp_i_normal_noise(c->Ha, y) + ecp_i_cone_noise(c->nl, y + 3);
    for (i = 0; i < 3; i++) c->Ha[4 * i] += ECP_I_CURVED * ecp_i_relax(c);
    c->kl = ecp_i_condense(c->nl, y + 3, c->fa, c->ga, c->L, ecp_i_tilt_unit(c), ecp_i_relax(c),
                           kink, c->fixed_a, c->slope_a, c->active_a, c->Ha);
    c->km = 0;
    if (!ecp_i_on_plane(c)) {
        const ecp_real *m = y + ecp_i_at_m(c);
        ecp_i_side_b *side = c->on_b;
        ecp_i_hessian(&c->b->shape, side->b_local, m, c->L, side->Hb);
        b[0] = b[1] = b[2] = ecp_i_norm(side->b_local) / c->L; /* from turned coordinates */
        c->n_noise += ecp_i_normal_noise(side->Hb, b) + ecp_i_cone_noise(c->nm, m);
        c->km =
            ecp_i_condense(c->nm, m, side->fb, side->gb, c->L, ecp_i_tilt_unit(c), ecp_i_relax(c),
                           kink, side->fixed_b, side->slope_b, side->active_b, side->Hb);
    }
    c->ny = 4 + c->kl + ecp_i_nf(c) + (ecp_i_on_plane(c) ? 0 : 1 + c->km);
    c->columns = c->ny + ecp_i_seats(c) + 1;
}

/* the row of a multiplier that is kept, over tilt; that of F where both are the same */
static ecp_real ecp_i_kept_row(const ecp_i_pair *c, ecp_real l, ecp_real f, ecp_real F)
{
    ecp_real da, db, tilt = ecp_i_tilt_unit(c);
    if (tilt >= 1) return F;
    return ecp_i_multiplier_row(l, -f / c->L, tilt, 0, &da, &db) / tilt;
}

/* The right-hand side: -F, less what the eliminated multipliers and the target change. F: the patch's
   rows; of a flat face's normal rows what is not above `floor` counts as zero. The column is zero
   before. */
static void ecp_i_block_rhs(const ecp_i_pair *c, const ecp_i_slopes *slopes, const ecp_real *y,
                            const ecp_real *F, ecp_real h, int centring, ecp_real floor)
{
    int i, k, ld = c->columns, first = ecp_i_on_plane(c) ? 3 : 4;
    ecp_real shift[3], da[3], *rhs = c->block + ld - 1;
    ecp_i_change t;
    /* where a surface is curved these rows say where the ECP is, and with it a moment */
    if (c->n_noise > 0) floor = 0;
    ECPSIM_MEMSET(&t, 0, sizeof t);
    ecp_i_shift(c->nl, c->ga, c->fixed_a, c->kl, c->active_a, shift);
    ecp_i_change_cone(c, shift, &t);
    if (centring) {
        ecp_i_target(c, y, da, t.p);
        ecp_i_change_ecp(c, da, &t);
    }
    if (!ecp_i_on_plane(c)) {
        ecp_i_shift(c->nm, c->on_b->gb, c->on_b->fixed_b, c->km, c->on_b->active_b, shift);
        ecp_i_add(t.rows, shift, t.rows);
    }
    ecp_i_column(c, slopes, &t, h, rhs);
    for (i = 0; centring && i < c->kl; i++) {
        int j = c->active_a[i];
        rhs[ld * (first + i)] = -c->slope_a[j] * ecp_i_dot(c->ga + 3 * j, da);
    }
    for (i = 0; i < ld - 1; i++) rhs[ld * i] = -rhs[ld * i];
    for (i = 0; i < first; i++, rhs += ld) *rhs -= ecp_i_abs(F[i]) > floor ? F[i] : 0;
    for (i = 0; i < c->kl; i++, rhs += ld) {
        int j = c->active_a[i];
        *rhs -= ecp_i_kept_row(c, y[3 + j], c->fa[j], F[first + j]);
    }
    for (i = 0; i < ecp_i_km(c); i++, rhs += ld) {
        int j = c->on_b->active_b[i];
        *rhs -= ecp_i_kept_row(c, y[ecp_i_at_m(c) + j], c->on_b->fb[j], F[4 + c->nl + j]);
    }
    for (k = 0; k <= ecp_i_nf(c); k++, rhs += ld) *rhs -= F[ecp_i_at_p(c) + k];
    /* held friction goes on to its limit, which it has nearly reached */
    rhs -= ld * ecp_i_nf(c);
    for (k = 0; centring && c->held && k < ecp_i_nf(c); k++, rhs += ld) {
        const ecp_i_projection *q = &slopes->cone;
        *rhs += (q->radius - q->z_norm) * q->z[k] / q->z_norm;
    }
}

/* Fills the block at the point of the last evaluation, of which ecp_i_block_condense has said how large
   it is. With `centring` the unknowns are counted from the target, so that the least step is the one
   that ends nearest to it. */
static void ecp_i_block_fill(ecp_i_pair *c, const ecp_real *y, const ecp_real *F, ecp_real h,
                             int centring, ecp_real floor)
{
    ecp_i_slopes slopes;
    ECPSIM_MEMSET(c->block, 0, (size_t)((c->columns - 1) * c->columns) * sizeof(ecp_real));
    ecp_i_pair_slopes(c, h, ecp_i_kink(centring), &slopes);
    ecp_i_block_columns(c, &slopes, h);
    ecp_i_block_rhs(c, &slopes, y, F, h, centring, floor);
}

/* Of what is left, the columns in which even a small pivot is one to take, as hardly a force depends
   on them that could make up for the row: a vertex near a vertex, for one, where the normal is fixed
   by d n alone, and d is small. */
static void ecp_i_block_slack(ecp_i_pair *c)
{
    int i, j, rows = c->columns - 1;
    for (j = c->pivots; j < c->ny; j++) {
        ecp_real most = 0, force = 0;
        for (i = c->pivots; i < rows; i++) {
            ecp_real size = ecp_i_abs(c->block[c->columns * i + j]);
            if (i < c->ny)
                most = ecp_i_max(most, size);
            else
                force = ecp_i_max(force, size);
        }
        c->row_tag[j] |= ECP_I_LAST;
        c->col_tag[j] &= ~ECP_I_LAST;
        if (force <= most) c->col_tag[j] |= ECP_I_LAST;
    }
}

/* What is no pivot in the column of the gap d: where that is hardly more than rounding as a whole, what is rounding
   beside its largest entry. Where nothing moves, h vs is next to nothing beside L, and of a gap that is open all
   entries are as small. */
static ecp_real ecp_i_no_gap_pivot(const ecp_i_pair *c)
{
    ecp_real most = 0;
    int i;
    for (i = 0; i < c->columns - 1; i++)
        most = ecp_i_max(most, ecp_i_abs(c->block[c->columns * i + 3 + c->kl]));
    return most < 4 * ECP_I_NO_PIVOT ? ECP_I_NO_PIVOT * most : ECP_I_NO_PIVOT;
}

/* of the columns that are to take small pivots, that of the gap */
static void ecp_i_block_gap(ecp_i_pair *c)
{
    int j;
    for (j = c->pivots; j < c->ny; j++) {
        int late = c->col_tag[j] & ECP_I_LAST;
        c->row_tag[j] |= ECP_I_GAP;
        c->col_tag[j] &= ~ECP_I_GAP;
        if (late && c->col_order[j] == 3 + c->kl) c->col_tag[j] |= ECP_I_GAP;
    }
}

/* in which order the rows have become pivots, which ecp_i_block_again needs: there where pairs are */
static int *ecp_i_row_order(const ecp_i_pair *c) { return c->col_order + c->ny; }

/* one stage: pivots larger than `tolerance` of the rows and columns whose tags the mask has */
static void ecp_i_block_stage(ecp_i_pair *c, int mask, ecp_real tolerance)
{
    c->pivots = ecp_eliminate(c->block, c->columns, c->columns - 1, c->columns, c->ny, c->ny,
                              c->pivots, mask, tolerance, c->row_tag, c->col_tag,
                              ECP_I_PAIRS ? ecp_i_row_order(c) : NULL, c->col_order);
}

/* geometry by geometry, impulses by impulses, then what is left of either by the other, and last the
   small ones */
static void ecp_i_block_eliminate(ecp_i_pair *c)
{
    ecp_real tolerance = ecp_i_relax(c) > 0 ? ECP_I_NO_PIVOT : ecp_i_sqrt(ECP_I_EPSILON) / 4;
    ecp_real smallest = ECP_I_NO_PIVOT;
    int i, before = -1;
    for (i = 0; i < c->ny; i++) {
        c->col_order[i] = i;
        if (ECP_I_PAIRS) ecp_i_row_order(c)[i] = i;
        c->row_tag[i] = c->col_tag[i] =
            i < c->ny - 1 - ecp_i_nf(c) ? ECP_I_GEOMETRY : ECP_I_IMPULSE;
    }
    if (!ecp_i_on_plane(c)) smallest = ecp_i_no_gap_pivot(c);
    c->pivots = 0;
    ecp_i_block_stage(c, ECP_I_GEOMETRY, tolerance);
    ecp_i_block_stage(c, ECP_I_IMPULSE, tolerance);
    ecp_i_block_stage(c, ECP_I_GEOMETRY | ECP_I_IMPULSE, tolerance);
    while (c->pivots < c->ny && c->pivots > before) {
        before = c->pivots;
        ecp_i_block_slack(c);
        ecp_i_block_stage(c, ECP_I_LAST, ECP_I_NO_PIVOT);
        if (c->pivots == before && !ecp_i_on_plane(c)) {
            ecp_i_block_gap(c);
            ecp_i_block_stage(c, ECP_I_GAP, smallest);
        }
    }
}

/* Of the step dy of a pair, the multipliers of g that were eliminated at once: they follow the way of b. */
static void ecp_i_recover_slack(const ecp_i_pair *c, const ecp_real *dv_a, const ecp_real *dv_b,
                                ecp_real h, ecp_real *dy)
{
    const ecp_i_side_b *b = c->on_b;
    ecp_real *dm = dy + ecp_i_at_m(c), db[3], cone[3];
    ecp_i_change t;
    int i, k, follows = 0;
    for (i = 0, k = 0; i < c->nm; i++) {
        if (k < c->km && b->active_b[k] == i) {
            k++;
            continue;
        }
        dm[i] = b->fixed_b[i];
        if (b->slope_b[i] > 0) follows = 1;
    }
    /* those that are off, as most are, do not */
    if (!follows) return;
    ecp_i_set3(0, 0, 0, cone);
    for (i = 0, k = 0; i < c->nl; i++) {
        int kept = k < c->kl && c->active_a[k] == i;
        ecp_i_axpy(cone, kept ? dy[3 + i] : c->fixed_a[i], c->ga + 3 * i, cone);
        k += kept;
    }
    ECPSIM_MEMSET(&t, 0, sizeof t);
    ecp_i_change_ecp(c, dy, &t);
    ecp_i_change_cone(c, cone, &t);
    if (ecp_i_moves_a(c)) ecp_i_change_motion(c, c->ma, h, dv_a, &t);
    if (ecp_i_moves_b(c)) ecp_i_change_motion(c, c->mb, h, dv_b, &t);
    t.d = h * c->V * dy[ecp_i_at_d(c)];
    ecp_i_change_of_b(c, &t, db);
    for (i = 0, k = 0; i < c->nm; i++) {
        if (k < c->km && b->active_b[k] == i)
            k++;
        else
            dm[i] += b->slope_b[i] * ecp_i_dot(b->gb + 3 * i, db);
    }
}

/* of a patch's step the unknown in column k: of a pivot, in the place of the right-hand side, or passed on */
static ecp_real ecp_i_solved(const ecp_i_pair *c, int k)
{
    return k < c->pivots ? c->block[c->columns * (k + 1) - 1] : c->left[k - c->pivots];
}

/* From the velocity changes dv (of A and B, scaled) and the unknowns passed on the step dy of all the patch's
   unknowns. */
static void ecp_i_block_recover(ecp_i_pair *c, const ecp_real *y, const ecp_real *dv_a,
                                const ecp_real *dv_b, ecp_real h, int centring, ecp_real *dy)
{
    ecp_real target_a[3], target_p[4], seen[9];
    const ecp_real *v = dv_a;
    int i, j, k, ld = c->columns, n = c->ny;
    if (ECP_I_PAIRS) {
        ecp_i_seat seats[12];
        int count = ecp_i_seat_all(c, 0, 6, seats);
        for (k = 0; k < ecp_i_seats(c); k++) seen[k] = 0;
        for (k = 0; k < count; k++) {
            const ecp_i_seat *s = seats + k;
            seen[s->at] += s->sees * (s->of < 6 ? dv_a[s->of] : dv_b[s->of - 6]);
        }
        v = seen;
    }
    /* solved in the order of the columns, then put where they belong */
    for (k = c->pivots - 1; k >= 0; k--) {
        const ecp_real *row = c->block + ld * k;
        ecp_real sum = row[ld - 1];
        for (j = k + 1; j < n; j++) sum -= row[j] * ecp_i_solved(c, j);
        for (j = 0; j < ecp_i_seats(c); j++) sum -= row[n + j] * v[j];
        c->block[ld * k + ld - 1] = sum / row[k];
    }
    for (k = 0; k < n; k++) {
        ecp_real value = ecp_i_solved(c, k);
        i = c->col_order[k];
        if (i < 3) {
            dy[i] = value;
        } else if (i < 3 + c->kl) {
            dy[3 + c->active_a[i - 3]] = value;
        } else if (ecp_i_on_plane(c) || i >= n - 1 - ecp_i_nf(c)) {
            dy[ecp_i_at_p(c) + i - (n - 1 - ecp_i_nf(c))] = value;
        } else if (i == 3 + c->kl) {
            dy[ecp_i_at_d(c)] = value;
        } else {
            dy[ecp_i_at_m(c) + c->on_b->active_b[i - 4 - c->kl]] = value;
        }
    }
    if (centring) {
        ecp_i_target(c, y, target_a, target_p);
        ecp_i_add(dy, target_a, dy);
        for (k = 0; k <= ecp_i_nf(c); k++) dy[ecp_i_at_p(c) + k] += target_p[k];
    }
    /* the multipliers that were eliminated before */
    for (i = 0, k = 0; i < c->nl; i++) {
        if (k < c->kl && c->active_a[k] == i) {
            k++;
        } else {
            dy[3 + i] = c->fixed_a[i] + c->slope_a[i] * ecp_i_dot(c->ga + 3 * i, dy);
        }
    }
    if (!ecp_i_on_plane(c)) ecp_i_recover_slack(c, dv_a, dv_b, h, dy);
}

/* The multipliers that were eliminated at once, for another point: their slopes stay as they are. 0 if one
   is to be kept now. */
static int ecp_i_condense_again(int count, const ecp_real *l, const ecp_real *f, ecp_real L,
                                ecp_real tilt, ecp_real tau, int kept, const int *active,
                                ecp_real *fixed)
{
    int i, k = 0;
    for (i = 0; i < count; i++) {
        ecp_real da, db, F;
        if (k < kept && active[k] == i) {
            k++;
            continue;
        }
        F = ecp_i_multiplier_row(l[i], -f[i] / L, tilt, tau, &da, &db);
        if (da < db) return 0;
        fixed[i] = -F / da;
    }
    return 1;
}

/* Another right-hand side, at the point of the last evaluation, for a block as it was eliminated at a
   point near by. own: ny reals. Returns 0 if that block has another form. */
static int ecp_i_block_again(ecp_i_pair *c, const ecp_real *y, const ecp_real *F, ecp_real h,
                             ecp_real floor, ecp_real *own)
{
    const ecp_i_side_b *b = c->on_b;
    ecp_i_slopes slopes;
    ecp_real *rhs = c->block + c->columns - 1;
    int i, k, ld = c->columns;
    if (!ecp_i_condense_again(c->nl, y + 3, c->fa, c->L, ecp_i_tilt_unit(c), ecp_i_relax(c), c->kl,
                              c->active_a, c->fixed_a))
        return 0;
    if (!ecp_i_on_plane(c) &&
        !ecp_i_condense_again(c->nm, y + ecp_i_at_m(c), b->fb, c->L, ecp_i_tilt_unit(c),
                              ecp_i_relax(c), c->km, b->active_b, b->fixed_b))
        return 0;
    for (i = 0; i < ld - 1; i++) rhs[ld * i] = 0;
    ecp_i_pair_slopes(c, h, 0, &slopes);
    ecp_i_block_rhs(c, &slopes, y, F, h, 0, floor);
    for (i = 0; i < c->ny; i++) own[i] = rhs[ld * i];
    for (i = 0; i < c->ny; i++) rhs[ld * i] = own[ecp_i_row_order(c)[i]];
    for (i = 1; i < ld - 1; i++) {
        const ecp_real *row = c->block + ld * i;
        for (k = 0; k < c->pivots && k < i; k++) rhs[ld * i] -= row[k] * rhs[ld * k];
    }
    return 1;
}

/* >>order: in which order the bodies of an island are eliminated */

/* The elimination of one body: [M B; C 0] of its six velocities, with the velocities of the bodies
   that are eliminated later as parameters u. Columns: own velocities, u, right-hand side; rows: own
   momentum, that of the others. What is left over goes to the parent: constraints on u, and forces
   that act on u alone. */
typedef struct ecp_i_front {
    int body;                      /* its place in the island */
    int width, *others;            /* number of velocities u, and whose they are */
    int parent, child, next;       /* the tree of fronts: indices, or -1 */
    ecp_i_pair *pairs;             /* patches that are assembled here, linked by next_here */
    int constraints, forces, open; /* rows that meet here; velocities that nothing fixes */
    int rank_c, rank_b, rank_m;    /* of the constraints, the forces, and what remains of M */
    int rank_g;                    /* of the forces that the open velocities change */
    int left_c, left_b;            /* passed on to the parent */
    ecp_real *R;                   /* v1 + R (v2, u) = c, rank_c rows of 7 + width */
    ecp_real *W;  /* momentum in the order of piv_b: forces from velocities, then v2 */
    ecp_real *G;  /* open velocities, from those and u: rows of open + width + 1 */
    ecp_real *Bt; /* forces + open rows of 6 + width: reflectors and R */
    ecp_real *tau_b, *tau_l;
    ecp_real *x;   /* the forces, in orthogonal combinations; then the open velocities */
    ecp_real *tau; /* of the reflectors of R, of momentum, of G, and of the constraints passed on */
    ecp_real *kept; /* what ecp_i_front_again needs, see ecp_i_front_keep */
    ecp_real size;  /* of the momentum rows that no force takes */
    ecp_real *C;    /* constraints x (7 + width), on the stack */
    ecp_real *M;    /* (6 + width) x (7 + width), on the stack */
    ecp_real *pass; /* on the stack: left C, left B^T, and M of the others */
    size_t level;   /* of the stack, before `pass` */
    int piv_c[6], piv_b[6], piv_m[6], piv_g[6];
} ecp_i_front;

typedef struct ecp_i_tree {
    ecp_real same;         /* relative difference below which constraints count as one */
    ecp_i_front *fronts;   /* in the order of elimination, children before parents */
    int *slot;             /* of each body: its columns in the present front */
    int *ints;             /* widest front */
    ecp_real *v, *u;       /* velocities of all bodies; those of the others of one front */
    unsigned char planned; /* the fronts are there, and their order */
    unsigned char damped;  /* momentum is told from nothing by ECP_I_SAME_DAMPED_MOMENTUM */
    size_t stack;          /* where the stack of the fronts begins */
    int many;              /* the last solve had many solutions */
    ecp_real h;
} ecp_i_tree;

/* the bodies as a graph: rows of bits, and what minimum degree keeps about them */
typedef struct ecp_i_graph {
    ecp_real *mass;
    int *degree, *rank;  /* rank: when it is eliminated, or -1 */
    int *held;           /* patches with bodies that are not in the island */
    ecp_i_front *fronts; /* in the order of elimination */
    unsigned *bits;
} ecp_i_graph;

#define ECP_I_WORD ((int)sizeof(unsigned) * 8)

static int ecp_i_bit(const unsigned *row, int j)
{
    return (int)(row[j / ECP_I_WORD] >> (j % ECP_I_WORD) & 1u);
}

static void ecp_i_set_bit(unsigned *row, int j, int on)
{
    unsigned bit = 1u << (j % ECP_I_WORD);
    row[j / ECP_I_WORD] = on ? row[j / ECP_I_WORD] | bit : row[j / ECP_I_WORD] & ~bit;
}

/* the first bit from number j on that is set; n or more: there is none */
static int ecp_i_next_bit(const unsigned *row, int n, int j)
{
    while (j < n && !ecp_i_bit(row, j)) {
        /* over a word without any at once */
        j += row[j / ECP_I_WORD] == 0 ? ECP_I_WORD - j % ECP_I_WORD : 1;
    }
    return j;
}

static int ecp_i_count_bits(const unsigned *row, int words)
{
    int i, count = 0;
    for (i = 0; i < words; i++) {
        unsigned x;
        for (x = row[i]; x; x &= x - 1) count++;
    }
    return count;
}

/* A body this many times as heavy as a neighbour is eliminated after it: the impulses between them
   are small against its own momentum, and bad pivots there. */
#define ECP_I_HEAVIER 100

static int ecp_i_has_lighter(const ecp_i_graph *g, int n, int i)
{
    const unsigned *row = g->bits + (n + ECP_I_WORD - 1) / ECP_I_WORD * i;
    int j;
    for (j = ecp_i_next_bit(row, n, 0); j < n; j = ecp_i_next_bit(row, n, j + 1)) {
        if (ECP_I_HEAVIER * g->mass[j] < g->mass[i]) return 1;
    }
    return 0;
}

/* eliminates body i as front k: its neighbours become neighbours of each other */
static void ecp_i_graph_eliminate(ecp_i_arena *arena, int n, ecp_i_graph *g, int i, int k)
{
    int words = (n + ECP_I_WORD - 1) / ECP_I_WORD, j, w, count = 0;
    const unsigned *row = g->bits + words * i;
    ecp_i_front *f = g->fronts + k;
    g->rank[i] = k;
    f->body = i;
    f->width = 6 * g->degree[i];
    f->others = ecp_i_take_ints(arena, g->degree[i]);
    for (j = ecp_i_next_bit(row, n, 0); j < n && !arena->overflow;
         j = ecp_i_next_bit(row, n, j + 1)) {
        unsigned *other = g->bits + words * j;
        f->others[count++] = j;
        for (w = 0; w < words; w++) other[w] |= row[w];
        ecp_i_set_bit(other, j, 0);
        ecp_i_set_bit(other, i, 0);
        g->degree[j] = ecp_i_count_bits(other, words);
    }
}

/* Is body i to be eliminated before `best` (-1: none yet)? It has fewer neighbours, or as many and fewer
   patches that hold it: what is held last passes the least on to the others. */
static int ecp_i_goes_first(const ecp_i_graph *g, int n, int i, int best)
{
    if (g->rank[i] >= 0) return 0;
    if (best >= 0) {
        if (g->degree[i] > g->degree[best]) return 0;
        if (g->degree[i] == g->degree[best] && g->held[i] >= g->held[best]) return 0;
    }
    return !ecp_i_has_lighter(g, n, i);
}

/* Minimum degree; of several bodies a neighbour of the last one, so that chains are followed, or the lowest
   index. A front's parent is the first of its others. */
static void ecp_i_minimum_degree(ecp_i_arena *arena, int n, ecp_i_graph *g)
{
    int words = (n + ECP_I_WORD - 1) / ECP_I_WORD, i, j, k,
        least = 0; /* least: no degree is below it */
    for (i = 0; i < n; i++) {
        g->degree[i] = ecp_i_count_bits(g->bits + words * i, words);
        g->rank[i] = -1;
    }
    for (k = 0; k < n && !arena->overflow; k++) {
        int best = -1, lowest = n;
        const ecp_i_front *last = g->fronts + (k > 0 ? k - 1 : 0); /* of width 0 as yet */
        for (i = 0; i < last->width / 6; i++) {
            j = last->others[i];
            /* only neighbours can have come below it */
            if (g->degree[j] < least) least = g->degree[j];
            if (ecp_i_goes_first(g, n, j, best)) best = j;
        }
        for (i = 0; i < n && !(best >= 0 && g->degree[best] <= least && g->held[best] == 0); i++) {
            if (g->rank[i] < 0 && g->degree[i] < lowest) lowest = g->degree[i];
            if (ecp_i_goes_first(g, n, i, best)) best = i;
        }
        if (i == n) least = lowest;
        ecp_i_graph_eliminate(arena, n, g, best, k);
    }
    for (k = 0; k < n && !arena->overflow; k++) {
        ecp_i_front *f = g->fronts + k;
        f->parent = f->child = f->next = -1;
        for (i = 0; i < f->width / 6; i++) {
            j = g->rank[f->others[i]];
            if (f->parent < 0 || j < f->parent) f->parent = j;
        }
    }
}

/* The fronts in postorder, so that what children pass on lies on top of the stack when their parent
   wants it. */
static void ecp_i_postorder(int n, const ecp_i_graph *g, ecp_i_front *fronts)
{
    int *size = g->degree, *start = g->rank, k, next = 0;
    for (k = 0; k < n; k++) size[k] = 1;
    for (k = 0; k < n; k++) {
        if (g->fronts[k].parent >= 0) size[g->fronts[k].parent] += size[k];
    }
    /* start: where a subtree begins, and then where its next child's will; size: its own place */
    for (k = n - 1; k >= 0; k--) {
        int parent = g->fronts[k].parent, *at = parent < 0 ? &next : start + parent;
        start[k] = *at;
        *at += size[k];
        size[k] += start[k] - 1;
    }
    for (k = 0; k < n; k++) {
        fronts[size[k]] = g->fronts[k];
        if (g->fronts[k].parent >= 0) fronts[size[k]].parent = size[g->fronts[k].parent];
    }
    for (k = n - 1; k >= 0; k--) {
        ecp_i_front *f = fronts + k;
        if (f->parent < 0) continue;
        f->next = fronts[f->parent].child;
        fronts[f->parent].child = k;
    }
}

/* >>front: factor and solve */

/* without pairs an island is one body, and its front stands alone */
static int ecp_i_width(const ecp_i_front *f) { return ECP_I_PAIRS ? f->width : 0; }
static int ecp_i_child(const ecp_i_front *f) { return ECP_I_PAIRS ? f->child : -1; }
static int ecp_i_passed(const ecp_i_front *f) { return ECP_I_PAIRS ? f->left_b : 0; }
static int ecp_i_passed_open(const ecp_i_front *f) { return ECP_I_PAIRS ? f->open : 0; }
static int ecp_i_front_body(const ecp_i_front *f) { return ECP_I_PAIRS ? f->body : 0; }

/* In ecp_i_front.tau the factors of R, of momentum, of G and of what is passed on begin so far apart. A front
   that stands alone needs one at a time. */
#define ECP_I_TAU (ECP_I_PAIRS ? 6 : 0)

/* rows that are there to be passed on: of momentum that is left over, and of open velocities */
#define ECP_I_ROWS_FOR_PARENT (ECP_I_PAIRS ? 6 : 0)

/* Constraints on the velocities that differ by less than this count as one. Two contacts that stick
   constrain a rigid body's stretch between them twice; at the end of the step the two are the same,
   but their derivatives differ by the turn within it, about h w. Taken as two they call for internal
   forces of 1 / (h w) times the load, and Newton's step is lost. */
#define ECP_I_SAME_CONSTRAINT ECP_R(1e-4)

/* But no step gets beyond a residual that only such a difference could mend: where Newton stalls they
   count as two down to this. */
#define ECP_I_FINEST_CONSTRAINT (ecp_i_sqrt(ECP_I_EPSILON) / 100)

/* a patch's row whose velocities count less than this, in the units of such rows, constrains nothing */
#define ECP_I_NO_CONSTRAINT ECP_R(1e-9)

/* Forces that act on a body, and momentum that fixes velocities, are more than what rounding leaves, which
   elimination makes grow by the ratios of masses and arms; but the smallest moment of inertia of a needle
   is 1e-6. A velocity that its momentum does not fix stays as it is. */
#define ECP_I_SAME_FORCE ecp_i_max(64 * ECP_I_EPSILON, ECP_R(1e-12))
#define ECP_I_SAME_MOMENTUM ecp_i_max(4 * ECP_I_EPSILON, ECP_R(1e-11))

/* Damped steps of large islands: a contact may be as stiff as the compliance's inverse squared there, 1e12 (a tilt
   moves the ECP, and with it the slip). Beside that the inertia, 1, must not count as nothing, or the turn it is to
   fix is left open, and each step leaves half of its momentum unbalanced. */
#define ECP_I_SAME_DAMPED_MOMENTUM ecp_i_max(4 * ECP_I_EPSILON, ECP_R(1e-13))

/* what an open velocity costs in the least step, should another front need it */
#define ECP_I_OPEN_WEIGHT ECP_R(100.0)

/* reorders n columns: column k is what column piv[k] was */
static void ecp_i_permute(int n, const int *piv, ecp_real *row)
{
    ecp_real was[6];
    int k;
    for (k = 0; k < n; k++) was[k] = row[k];
    for (k = 0; k < n; k++) row[k] = was[piv[k]];
}

/* row -= row[k] times equation k, for the unit equations of ecp_i_solve_rows, which leaves zeros at the
   first `rank` places: not written, they still hold what they were */
static void ecp_i_insert(int rank, int all, const ecp_real *A, int ld, ecp_real *row)
{
    ecp_i_subtract_rows(all - rank, rank, row, A + rank, ld, row + rank);
}

/* Constraints: the first rank_c velocities (in the order of piv_c) from the others. What is left of
   the constraints stays in C from row rank_c on. */
static void ecp_i_front_constrain(const ecp_i_tree *t, ecp_i_front *f, ecp_real *tau)
{
    int ld = 7 + ecp_i_width(f), i;
    f->rank_c = ecp_i_qr(f->constraints, 6, ld, f->C, ld, tau, f->piv_c, t->same, t->same);
    if (ECP_I_PAIRS) ecp_i_copy(ld * f->rank_c, f->C, f->R);
    ecp_i_solve_rows(f->rank_c, ld, f->R, ld);
    for (i = 0; i < 6 + ecp_i_width(f); i++) ecp_i_permute(6, f->piv_c, f->M + ld * i);
}

/* Forces: orthogonal combinations of them, the first rank_b of which act on the body, each on one
   more row of its momentum (in the order of piv_b); forward elimination of these from the momentum. */
static void ecp_i_front_balance(ecp_i_front *f)
{
    int ld = 7 + ecp_i_width(f), ldb = 6 + ecp_i_width(f), i, k;
    f->rank_b = ecp_i_qr(f->forces, 6, ldb, f->Bt, ldb, f->tau_b, f->piv_b, ECP_I_SAME_FORCE,
                         ECP_I_SAME_FORCE);
    for (i = 0; i < 6; i++) ecp_i_copy(ld, f->M + ld * f->piv_b[i], f->W + ld * i);
    for (i = 1; i < ldb; i++) {
        ecp_real factor[6];
        for (k = 0; k < f->rank_b && k < i; k++) {
            factor[k] = f->Bt[ldb * k + i] / f->Bt[ldb * k + k];
        }
        ecp_i_subtract_rows(ld, k, factor, f->W, ld, (i < 6 ? f->W : f->M) + ld * i);
    }
}

/* The momentum that no force takes fixes rank_m of the remaining velocities; equations that are left
   over become constraints on the others. Returns how many of those there are, from row rank_c of C. */
static int ecp_i_front_momentum(const ecp_i_tree *t, ecp_i_front *f, ecp_real *tau)
{
    int ld = 7 + ecp_i_width(f), free = 6 - f->rank_c, rows = 6 - f->rank_b, all = ld - f->rank_c;
    int left = f->constraints - f->rank_c, i, j;
    ecp_real *S = f->W + ld * f->rank_b + f->rank_c, size = 0;
    ecp_real same = ECP_I_PAIRS && t->damped ? ECP_I_SAME_DAMPED_MOMENTUM : ECP_I_SAME_MOMENTUM;
    for (i = 0; i < rows; i++) {
        ecp_i_insert(f->rank_c, ld, f->R, ld, f->W + ld * (f->rank_b + i));
        size = ecp_i_max(size, ecp_i_row_size(all - 1, S + ld * i));
    }
    f->size = size;
    f->rank_m = ecp_i_qr(rows, free, all, S, ld, tau, f->piv_m, same, same);
    ecp_i_solve_rows(f->rank_m, all, S, ld);
    for (i = f->rank_m; ECP_I_PAIRS && i < rows; i++) {
        const ecp_real *row = S + ld * i + free;
        ecp_real rest = ecp_i_row_size(ecp_i_width(f), row),
                 *to = f->C + ld * (f->rank_c + left) + 6;
        if (!(rest > ECP_I_SAME_FORCE * size)) continue;
        for (j = 0; j <= ecp_i_width(f); j++) to[j] = row[j] / rest;
        left++;
    }
    for (i = 6; i < 6 + ecp_i_width(f); i++) {
        ecp_i_insert(f->rank_c, ld, f->R, ld, f->M + ld * i);
        ecp_i_permute(free, f->piv_m, f->M + ld * i + f->rank_c);
        ecp_i_insert(f->rank_m, all, S, ld, f->M + ld * i + f->rank_c);
    }
    f->open = free - f->rank_m;
    return left;
}

/* Velocities that neither the constraints nor the momentum fix, because there are more ways to
   balance momentum by forces than there are constraints: they are where the forces of this front
   are least, plus a part that is passed on like a force (another front may need it). */
static void ecp_i_front_open(ecp_i_arena *arena, ecp_i_front *f, ecp_real *tau)
{
    int ld = 7 + ecp_i_width(f), ldb = 6 + ecp_i_width(f), ldg = f->open + ecp_i_width(f) + 1, i, j;
    const ecp_real *S = f->W + ld * f->rank_b + f->rank_c;
    f->G = ecp_i_take_reals(arena, 7, ld);
    if (!f->G) return;
    for (i = 0; i < f->rank_b; i++) {
        ecp_real *G = f->G + ldg * i, *row = f->G + ldg * f->rank_b;
        /* row i of W in terms of the open velocities and u */
        ecp_i_copy(ld, f->W + ld * i, row);
        ecp_i_insert(f->rank_c, ld, f->R, ld, row);
        ecp_i_permute(6 - f->rank_c, f->piv_m, row + f->rank_c);
        ecp_i_insert(f->rank_m, ld - f->rank_c, S, ld, row + f->rank_c);
        for (j = 0; j < ldg; j++) G[j] = row[f->rank_c + f->rank_m + j] / f->Bt[ldb * i + i];
    }
    f->rank_g = ecp_i_qr(f->rank_b, f->open, ldg, f->G, ldg, tau, f->piv_g, ECP_I_SAME_FORCE, 0);
    ecp_i_solve_rows(f->rank_g, ldg, f->G, ldg);
    for (i = 0; i < ecp_i_width(f); i++) {
        ecp_real *row = f->M + ld * (6 + i) + f->rank_c + f->rank_m;
        for (j = 0; j < f->open; j++) {
            f->Bt[ldb * (f->forces + j) + 6 + i] = row[j] / ECP_I_OPEN_WEIGHT;
        }
        ecp_i_permute(f->open, f->piv_g, row);
        ecp_i_insert(f->rank_g, ldg, f->G, ldg, row);
    }
}

/* x[n] of a row in the columns (own, u) */
static ecp_real ecp_i_row_value(int n, const ecp_real *row, const ecp_real *x)
{
    ecp_real sum = 0;
    int j;
    for (j = 0; j < n; j++) sum += row[j] * x[j];
    return sum;
}

/* the part of such a row that the velocities u of the others have */
static ecp_real ecp_i_others_value(const ecp_i_front *f, const ecp_real *row, const ecp_real *u)
{
    return ECP_I_PAIRS ? ecp_i_row_value(f->width, row, u) : ECP_R(0);
}

/* What the parent gets, as few rows as have the same effect: C and c (left_c rows), B^T (left_b
   rows), and the others' momentum. left: rows of C to pass. */
static void ecp_i_front_pass(const ecp_i_tree *t, ecp_i_front *f, int left)
{
    int n = ecp_i_width(f), ld = 7 + n, ldb = 6 + n, *piv = t->ints, i, j;
    ecp_real *C = f->C + ld * f->rank_c + 6, *B = f->Bt + ldb * f->rank_b + 6, *to = f->pass;
    ecp_real *tau = f->tau + 3 * ECP_I_TAU, acts = f->rank_b > 0 ? ecp_i_abs(f->Bt[0]) : ECP_R(0);
    f->left_c = ecp_i_qr(left, n, n + 1, C, ld, tau, piv, t->same, t->same);
    for (i = 0; i < f->left_c; i++, to += n + 1) {
        for (j = 0; j < n; j++) to[piv[j]] = j >= i ? C[ld * i + j] : ECP_R(0);
        to[n] = C[ld * i + n];
    }
    f->left_b = ecp_i_qr(f->forces + f->open - f->rank_b, n, n, B, ldb, f->tau_l, piv,
                         ECP_I_SAME_FORCE, ECP_I_SAME_FORCE * acts);
    for (i = 0; i < f->left_b; i++, to += n) {
        for (j = 0; j < n; j++) to[piv[j]] = j >= i ? B[ldb * i + j] : ECP_R(0);
    }
    for (i = 0; i < n; i++, to += n + 1) {
        ecp_i_copy(n + 1, f->M + ld * (6 + i) + 6, to);
    }
}

/* adds what a child passes on */
static void ecp_i_front_extend(const ecp_i_tree *t, ecp_i_front *f, const ecp_i_front *child,
                               int constraints, int forces)
{
    int n = ecp_i_width(child), ld = 7 + ecp_i_width(f), ldb = 6 + ecp_i_width(f), i, j;
    int *at = t->ints; /* the columns of the child's velocities in the front */
    const ecp_real *from = child->pass;
    for (j = 0; j < n; j++) at[j] = t->slot[child->others[j / 6]] + j % 6;
    for (i = 0; i < child->left_c; i++, from += n + 1) {
        ecp_real *row = f->C + ld * (constraints + i);
        for (j = 0; j < n; j++) row[at[j]] = from[j];
        row[ld - 1] = from[n];
    }
    for (i = 0; i < child->left_b; i++, from += n) {
        ecp_real *row = f->Bt + ldb * (forces + i);
        for (j = 0; j < n; j++) row[at[j]] = from[j];
    }
    for (i = 0; i < n; i++, from += n + 1) {
        ecp_real *row = f->M + ld * at[i];
        for (j = 0; j < n; j++) row[at[j]] += from[j];
        row[ld - 1] += from[n];
    }
}

/* the patch's unknown that is passed on as force i: what a unit of it costs in the least step */
static ecp_real ecp_i_force_weight(const ecp_i_pair *c, int i)
{
    return c->col_tag[c->pivots + i] & ECP_I_GEOMETRY ? ECP_I_ECP_WEIGHT : ECP_R(1);
}

/* Without pairs nobody asks for the rest of a block once more (ecp_i_block_again): of the rows behind the pivots'
   those columns are packed that the front wants, and the memory behind them is given back. */
static void ecp_i_block_pack(ecp_i_arena *arena, const ecp_i_pair *c)
{
    int i, j, ld = c->columns;
    ecp_real *to = c->block + ld * c->pivots;
    if (ECP_I_PAIRS) return;
    for (i = c->pivots; i < ld - 1; i++) {
        for (j = i < c->ny ? c->ny : c->pivots; j < ld; j++) *to++ = c->block[ld * i + j];
    }
    ecp_i_release(arena, (size_t)((unsigned char *)to - arena->base + 7) & ~(size_t)7, arena->top);
}

/* of an eliminated block the row i of its own that is left, in the columns of the velocities */
static const ecp_real *ecp_i_left_row(const ecp_i_pair *c, int i)
{
    const ecp_real *rows = c->block + c->columns * c->pivots;
    return ECP_I_PAIRS ? rows + c->columns * i + c->ny : rows + 7 * i;
}

/* and the row i of momentum, in the columns that are left and those of the velocities */
static const ecp_real *ecp_i_momentum_row(const ecp_i_pair *c, int i)
{
    int left = c->ny - c->pivots;
    return ECP_I_PAIRS ? c->block + c->columns * (c->ny + i) + c->pivots
                       : ecp_i_left_row(c, left) + (left + 7) * i;
}

/* the largest coefficient of a constraint that a patch passes on from row i of those that are left; 0: none */
static ecp_real ecp_i_constraint_size(const ecp_i_tree *t, const ecp_i_pair *c, int i)
{
    ecp_real size = ecp_i_row_size(ecp_i_seats(c), ecp_i_left_row(c, i));
    ecp_real unit = c->row_tag[c->pivots + i] & ECP_I_GEOMETRY ? t->h * c->V / c->L : ECP_R(1);
    return size <= ECP_I_NO_CONSTRAINT * ecp_i_min(unit, 1) ? ECP_R(0) : size;
}

/* the velocities of the patch's bodies, and the columns that these have in the present front */
static int ecp_i_patch_seats(const ecp_i_tree *t, const ecp_i_pair *c, ecp_i_seat seats[12])
{
    int a = ECP_I_PAIRS && ecp_i_moves_a(c) ? t->slot[c->ma->at / 6] : 0;
    int b = ecp_i_moves_b(c) ? t->slot[c->mb->at / 6] : 0;
    if (!ECP_I_PAIRS) return 6;
    return ecp_i_seat_all(c, a, b, seats);
}

/* number i of these; one body alone has no table of them */
static ecp_i_seat ecp_i_seat_number(const ecp_i_pair *c, const ecp_i_seat *seats, int i)
{
    return ECP_I_PAIRS ? seats[i] : ecp_i_seat_of(c, 0, i, i);
}

/* Adds a patch's eliminated block: what is left of its own rows (constraints, their largest
   coefficient made 1) and columns (forces), and its share of the momentum rows. */
static void ecp_i_front_patch(const ecp_i_tree *t, ecp_i_front *f, const ecp_i_pair *c,
                              int constraints, int forces)
{
    int i, j, left = c->ny - c->pivots, rhs = ecp_i_seats(c);
    int ldc = 7 + ecp_i_width(f), ldb = 6 + ecp_i_width(f);
    ecp_i_seat seats[12];
    int count = ecp_i_patch_seats(t, c, seats);
    for (i = 0; i < left; i++) {
        const ecp_real *row = ecp_i_left_row(c, i);
        ecp_real size = ecp_i_constraint_size(t, c, i), *C = f->C + ldc * (constraints + i);
        if (!(size > 0)) continue;
        for (j = 0; j < count; j++) {
            const ecp_i_seat v = ecp_i_seat_number(c, seats, j);
            C[v.of] = v.sees * row[v.at] / size;
        }
        C[ldc - 1] = row[rhs] / size;
    }
    for (i = 0; i < count; i++) {
        const ecp_i_seat m = ecp_i_seat_number(c, seats, i);
        const ecp_real *row = ecp_i_momentum_row(c, m.at);
        ecp_real *M = f->M + ldc * m.of, *Bt = f->Bt + ldb * forces + m.of;
        for (j = 0; j < left; j++, row++, Bt += ldb) {
            *Bt = m.takes * *row / ecp_i_force_weight(c, j);
        }
        M[ldc - 1] += m.takes * row[rhs];
        for (j = 0; j < count; j++) {
            const ecp_i_seat v = ecp_i_seat_number(c, seats, j);
            M[v.of] += m.takes * v.sees * row[v.at];
        }
    }
}

/* the columns of the bodies in the front */
static void ecp_i_front_slots(const ecp_i_tree *t, const ecp_i_front *f)
{
    int i;
    if (!ECP_I_PAIRS) return;
    t->slot[f->body] = 0;
    for (i = 0; i < ecp_i_width(f) / 6; i++) t->slot[f->others[i]] = 6 + 6 * i;
}

/* Takes the front's memory, what must last from below and the rest from the stack; sets its columns.
   Returns 0 if there is none left. */
static int ecp_i_front_carve(const ecp_i_tree *t, ecp_i_arena *arena, ecp_i_front *f)
{
    const ecp_i_pair *c;
    int i, n = ecp_i_width(f), ld = 7 + n;
    f->constraints = f->forces = f->open = 0;
    for (c = f->pairs; c; c = c->next_here) f->constraints += c->ny - c->pivots;
    f->forces = f->constraints;
    f->level = arena->top;
    if (ecp_i_child(f) >= 0) f->level = t->fronts[f->child].level;
    for (i = ecp_i_child(f); i >= 0; i = t->fronts[i].next) {
        f->constraints += t->fronts[i].left_c;
        f->forces += t->fronts[i].left_b;
    }
    if (ECP_I_PAIRS) f->R = ecp_i_take_reals(arena, 6, ld);
    f->W = ecp_i_take_reals(arena, 6, ld);
    f->Bt = ecp_i_take_reals(arena, f->forces + ECP_I_ROWS_FOR_PARENT, 6 + n);
    f->tau_b = ecp_i_take_reals(arena, 6, 1);
    if (ECP_I_PAIRS) {
        f->tau_l = ecp_i_take_reals(arena, n, 1);
        f->tau = ecp_i_take_reals(arena, 3 * ECP_I_TAU + n, 1);
    }
    f->x = ecp_i_take_reals(arena, f->forces + ECP_I_ROWS_FOR_PARENT, 1);
    f->C = ecp_i_take_stack(arena, f->constraints + ECP_I_ROWS_FOR_PARENT, ld);
    if (!ECP_I_PAIRS) f->R = f->C; /* nobody takes the stack from a front that stands alone */
    f->M = ecp_i_take_stack(arena, 6 + n, ld);
    if (arena->overflow) return 0;
    ECPSIM_MEMSET(f->Bt, 0, (size_t)(f->forces * (6 + n)) * sizeof(ecp_real));
    ECPSIM_MEMSET(f->C, 0, (size_t)(f->constraints * ld) * sizeof(ecp_real));
    ECPSIM_MEMSET(f->M, 0, (size_t)((6 + n) * ld) * sizeof(ecp_real));
    ecp_i_front_slots(t, f);
    return 1;
}

/* the most reals that a front can pass on */
static int ecp_i_pass_size(const ecp_i_front *f, int left)
{
    int n = ecp_i_width(f), forces = f->forces + f->open - f->rank_b;
    if (left > n) left = n;
    if (forces > n) forces = n;
    return left * (n + 1) + forces * n + n * (n + 1);
}

/* Rows of ld reals, the first `columns` of each, one after the other; where they end */
static ecp_real *ecp_i_pack(int rows, int columns, const ecp_real *A, int ld, ecp_real *to)
{
    int i;
    for (i = 0; i < rows; i++, A += ld, to += columns) {
        ecp_i_copy(columns, A, to);
    }
    return to;
}

/* Keeps what the stack has of the elimination and another right-hand side needs: the reflectors of the
   constraints, the coefficients of the velocities here in the others' momentum, the reflectors of what is left
   of the constraints; and room for what such a right-hand side passes on. left: rows of C that are left. */
static void ecp_i_front_keep(ecp_i_arena *arena, ecp_i_front *f, int left)
{
    int n = ecp_i_width(f), ld = 7 + n;
    ecp_real *to = f->kept = ecp_i_take_reals(
        arena, f->constraints * f->rank_c + 7 * n + left * f->left_c + f->left_c, 1);
    if (!to) return;
    to = ecp_i_pack(f->constraints, f->rank_c, f->C, ld, to);
    to = ecp_i_pack(n, 6, f->M + ld * 6, ld, to);
    ecp_i_pack(left, f->left_c, f->C + ld * f->rank_c + 6, ld, to);
}

/* Moves what is passed on to where the children's began, and frees the rest of the stack. */
static void ecp_i_front_settle(ecp_i_arena *arena, ecp_i_front *f)
{
    int n = ecp_i_width(f), rest = f->left_c * (n + 1) + f->left_b * n + n * (n + 1), piece, apart;
    ecp_real *to;
    ecp_i_release(arena, arena->used, f->level);
    to = ecp_i_take_stack(arena, rest, 1);
    /* the two may overlap: from the end, in pieces that do not */
    apart = (int)(to - f->pass);
    for (; rest > 0 && apart > 0; rest -= piece) {
        piece = rest < apart ? rest : apart;
        ECPSIM_MEMCPY(to + rest - piece, f->pass + rest - piece, (size_t)piece * sizeof(ecp_real));
    }
    f->pass = to;
}

/* Eliminates one body. m: its inertia, b: the right-hand side of its momentum rows. */
static int ecp_i_front_factor(const ecp_i_tree *t, ecp_i_arena *arena, ecp_i_front *f,
                              const ecp_i_motion *m, const ecp_real *b)
{
    const ecp_i_pair *c;
    ecp_real alone[6], *tau = alone, unit = m->mass * m->length * m->length;
    int i, j, n = ecp_i_width(f), ld = 7 + n, constraints = 0, forces = 0, left;
    if (!ecp_i_front_carve(t, arena, f)) return 0;
    if (ECP_I_PAIRS) tau = f->tau;
    for (i = 0; i < 3; i++) {
        f->M[ld * i + i] = 1;
        for (j = 0; j < 3; j++) f->M[ld * (3 + i) + 3 + j] = m->inertia[3 * i + j] / unit;
    }
    for (i = 0; i < 6; i++) f->M[ld * i + ld - 1] = b[i];
    for (c = f->pairs; c; c = c->next_here) {
        ecp_i_front_patch(t, f, c, constraints, forces);
        constraints += c->ny - c->pivots;
        forces += c->ny - c->pivots;
    }
    for (i = ecp_i_child(f); i >= 0; i = t->fronts[i].next) {
        const ecp_i_front *child = t->fronts + i;
        ecp_i_front_extend(t, f, child, constraints, forces);
        constraints += child->left_c;
        forces += child->left_b;
    }
    ecp_i_front_constrain(t, f, tau);
    ecp_i_front_balance(f);
    left = ecp_i_front_momentum(t, f, tau + ECP_I_TAU);
    if (f->open > 0) ecp_i_front_open(arena, f, tau + 2 * ECP_I_TAU);
    if (arena->overflow) return 0;
    if (!ECP_I_PAIRS) {
        ecp_i_release(arena, arena->used, f->level);
        return 1;
    }
    f->pass = ecp_i_take_stack(arena, ecp_i_pass_size(f, left), 1);
    if (arena->overflow) return 0;
    ecp_i_front_pass(t, f, left);
    ecp_i_front_keep(arena, f, left);
    ecp_i_front_settle(arena, f);
    return !arena->overflow;
}

/* The velocities and forces of a front from those of the others (t->v) and from what the parent found
   for the forces passed on; hands their parts on to the children and to the patches. */
static void ecp_i_front_recover(const ecp_i_tree *t, ecp_i_front *f)
{
    int n = ecp_i_width(f), ld = 7 + n, ldb = 6 + n, ldg = f->open + n + 1, free = 6 - f->rank_c, i,
        j, k;
    const ecp_real *S = f->W + ld * f->rank_b + f->rank_c;
    ecp_real v[6], q[6], *x = f->x, *u = t->u;
    ecp_i_pair *c;
    for (j = 0; j < n; j++) u[j] = t->v[6 * f->others[j / 6] + j % 6];
    for (i = f->rank_b + ecp_i_passed(f); i < f->forces + ecp_i_passed_open(f); i++) x[i] = 0;
    ecp_qr_apply_q(f->forces + f->open - f->rank_b, ecp_i_passed(f), f->Bt + ldb * f->rank_b + 6,
                   ldb, f->tau_l, x + f->rank_b);
    for (j = 0; j < f->open; j++) {
        q[j] = j < ecp_i_passed_open(f) ? x[f->forces + j] / ECP_I_OPEN_WEIGHT : ECP_R(0);
    }
    for (k = 0; f->open > 0 && k < f->rank_g; k++) {
        const ecp_real *row = f->G + ldg * k;
        ecp_real sum = row[ldg - 1] - ecp_i_others_value(f, row + f->open, u);
        for (j = f->rank_g; j < f->open; j++) sum -= row[j] * q[f->piv_g[j]];
        q[f->piv_g[k]] += sum;
    }
    for (j = 0; j < f->open; j++) v[f->rank_c + f->piv_m[f->rank_m + j]] = q[j];
    for (k = 0; k < f->rank_m; k++) {
        const ecp_real *row = S + ld * k;
        ecp_real sum = row[free + n] - ecp_i_others_value(f, row + free, u);
        for (j = 0; j < f->open; j++) sum -= row[f->rank_m + j] * q[j];
        v[f->rank_c + f->piv_m[k]] = sum;
    }
    for (k = 0; k < f->rank_c; k++) {
        const ecp_real *row = f->R + ld * k;
        v[k] = row[ld - 1] - ecp_i_row_value(free, row + f->rank_c, v + f->rank_c) -
               ecp_i_others_value(f, row + 6, u);
    }
    for (k = 0; k < f->rank_b; k++) {
        const ecp_real *row = f->W + ld * k;
        x[k] = (row[ld - 1] - ecp_i_row_value(6, row, v) - ecp_i_others_value(f, row + 6, u)) /
               f->Bt[ldb * k + k];
    }
    for (k = 0; k < 6; k++) t->v[6 * ecp_i_front_body(f) + f->piv_c[k]] = v[k];
    ecp_qr_apply_q(f->forces, f->rank_b, f->Bt, ldb, f->tau_b, x);
    for (c = f->pairs, i = 0; c; c = c->next_here) {
        c->left = x + i;
        for (k = 0; k < c->ny - c->pivots; k++, i++) x[i] /= ecp_i_force_weight(c, k);
    }
    for (k = ecp_i_child(f); k >= 0; k = t->fronts[k].next) {
        ecp_i_front *child = t->fronts + k;
        for (j = 0; j < child->left_b; j++) child->x[child->rank_b + j] = x[i++];
    }
}

/* Q^T b, and then the unknowns of [R1 ..] x = b, for the reflectors and the R1 of ecp_i_qr in A */
static void ecp_i_solve_qr(int rows, int rank, const ecp_real *A, int ld, const ecp_real *tau,
                           ecp_real *b)
{
    int i, k;
    ecp_qr_apply_qt(rows, rank, A, ld, tau, b);
    for (i = rank - 1; i >= 0; i--) {
        for (k = i + 1; k < rank; k++) b[i] -= A[ld * i + k] * b[k];
        b[i] /= A[ld * i + i];
    }
}

/* Other right-hand sides of a front: of its constraints (rest), and of the momentum of its body and the others (m),
   from b, the patches' blocks and the children. */
static void ecp_i_front_collect(const ecp_i_tree *t, const ecp_i_front *f, const ecp_real *b,
                                ecp_real *rest, ecp_real *m)
{
    const ecp_i_pair *c;
    int i, j, n = ecp_i_width(f);
    ecp_i_front_slots(t, f);
    for (i = 0; i < 6 + n; i++) m[i] = i < 6 ? b[i] : ECP_R(0);
    for (c = f->pairs; c; c = c->next_here) {
        const ecp_real *rhs = c->block + c->columns - 1;
        ecp_i_seat seats[12];
        int count = ecp_i_patch_seats(t, c, seats);
        for (i = c->pivots; i < c->ny; i++) {
            ecp_real size = ecp_i_constraint_size(t, c, i - c->pivots);
            *rest++ = size > 0 ? rhs[c->columns * i] / size : ECP_R(0);
        }
        for (i = 0; i < count; i++) {
            m[seats[i].of] += seats[i].takes * rhs[c->columns * (c->ny + seats[i].at)];
        }
    }
    for (i = f->child; i >= 0; i = t->fronts[i].next) {
        const ecp_i_front *child = t->fronts + i;
        const ecp_real *from = child->pass;
        for (j = 0; j < child->left_c; j++) *rest++ = *from++;
        for (j = 0; j < ecp_i_width(child); j++) {
            m[t->slot[child->others[j / 6]] + j % 6] += *from++;
        }
    }
}

/* Takes other right-hand sides through the front as it was eliminated, in the steps of ecp_i_front_factor. The
   columns that ecp_i_front_recover reads, and what the parent gets, are then those of a step with them. */
static void ecp_i_front_again(const ecp_i_tree *t, ecp_i_arena *arena, ecp_i_front *f,
                              const ecp_real *b)
{
    int i, j, k, n = ecp_i_width(f), ld = 7 + n, ldb = 6 + n, ldg = f->open + n + 1;
    int rows = 6 - f->rank_b, left = f->constraints - f->rank_c, fixed = f->rank_c + f->rank_m;
    size_t level = arena->top;
    const ecp_real *momentum = f->kept + f->constraints * f->rank_c, *passed = momentum + 6 * n;
    ecp_real *S = f->W + ld * f->rank_b + f->rank_c, w[6], known[6], v[6];
    ecp_real *rest = ecp_i_take_stack(arena, f->constraints + 12 + n, 1), *m;
    if (!rest) return;
    m = rest + f->constraints + 6;
    ecp_i_front_collect(t, f, b, rest, m);
    /* known: the right-hand sides of what fixes the velocities */
    ecp_i_solve_qr(f->constraints, f->rank_c, f->kept, f->rank_c, f->tau, rest);
    for (i = 0; i < 6; i++) {
        known[i] = i < f->rank_c ? rest[i] : ECP_R(0);
        if (i < f->rank_c) f->R[ld * i + ld - 1] = rest[i];
        w[i] = m[f->piv_b[i]];
    }
    for (i = 1; i < ldb; i++) {
        ecp_real *to = i < 6 ? w + i : m + i;
        for (k = 0; k < f->rank_b && k < i; k++)
            *to -= f->Bt[ldb * k + i] / f->Bt[ldb * k + k] * w[k];
    }
    for (i = 0; i < f->rank_b; i++) f->W[ld * i + ld - 1] = w[i];
    for (; i < 6; i++) w[i] -= ecp_i_row_value(f->rank_c, f->W + ld * i, known);
    ecp_i_solve_qr(rows, f->rank_m, S, ld, f->tau + ECP_I_TAU, w + f->rank_b);
    for (i = 0; i < f->rank_m; i++) {
        known[f->rank_c + i] = w[f->rank_b + i];
        S[ld * i + ld - 1 - f->rank_c] = w[f->rank_b + i];
    }
    for (; i < rows; i++) {
        ecp_real size = ecp_i_row_size(n, S + ld * i + 6 - f->rank_c);
        if (size > ECP_I_SAME_FORCE * f->size) rest[f->rank_c + left++] = w[f->rank_b + i] / size;
    }
    if (f->open > 0) {
        /* the velocities with the open ones zero, and what that leaves of the momentum to the forces */
        for (i = 0; i < 6; i++) v[i] = 0;
        for (i = 0; i < f->rank_m; i++) v[f->rank_c + f->piv_m[i]] = known[f->rank_c + i];
        for (i = 0; i < f->rank_c; i++) {
            v[i] =
                known[i] - ecp_i_row_value(6 - f->rank_c, f->R + ld * i + f->rank_c, v + f->rank_c);
        }
        for (i = 0; i < f->rank_b; i++) {
            w[i] = (w[i] - ecp_i_row_value(6, f->W + ld * i, v)) / f->Bt[ldb * i + i];
        }
        ecp_i_solve_qr(f->rank_b, f->rank_g, f->G, ldg, f->tau + 2 * ECP_I_TAU, w);
        for (i = 0; i < f->rank_g; i++) known[fixed + i] = f->G[ldg * i + ldg - 1] = w[i];
    }
    ecp_qr_apply_qt(left, f->left_c, passed, f->left_c, f->tau + 3 * ECP_I_TAU, rest + f->rank_c);
    f->pass = f->kept + f->constraints * f->rank_c + 6 * n + left * f->left_c;
    for (i = 0; i < f->left_c; i++) f->pass[i] = rest[f->rank_c + i];
    for (j = 0; j < n; j++) f->pass[i++] = m[6 + j] - ecp_i_row_value(6, momentum + 6 * j, known);
    arena->top = level;
}

/* Solves for v and the forces: a null-space method by orthogonal steps, with ranks found on the way.
   Where solutions are many, the forces have the least weighted norm; where equations contradict each
   other, least squares. b: the right-hand side of the momentum rows, six a body. Returns 0 if memory
   runs out. */
static int ecp_i_tree_solve(ecp_i_tree *t, ecp_i_arena *arena, int n, const ecp_i_motion *motions,
                            const int *bodies, const ecp_real *b)
{
    int k;
    t->many = 0;
    for (k = 0; k < n; k++) {
        ecp_i_front *f = t->fronts + k;
        int body = ecp_i_front_body(f);
        if (!ecp_i_front_factor(t, arena, f, motions + (ECP_I_PAIRS ? bodies[body] : 0),
                                b + 6 * body))
            return 0;
        t->many += f->forces + f->open - f->rank_b - ecp_i_passed(f);
    }
    for (k = n - 1; k >= 0; k--) ecp_i_front_recover(t, t->fronts + k);
    return 1;
}

/* The same for other right-hand sides, b and those of the patches' blocks, with the elimination of the last
   one. */
static int ecp_i_tree_again(ecp_i_tree *t, ecp_i_arena *arena, int n, const ecp_real *b)
{
    int k;
    for (k = 0; k < n && !arena->overflow; k++) {
        ecp_i_front_again(t, arena, t->fronts + k, b + 6 * t->fronts[k].body);
    }
    for (k = n - 1; k >= 0 && !arena->overflow; k--) ecp_i_front_recover(t, t->fronts + k);
    return !arena->overflow;
}

/* >>island: the problem of a group of bodies that touch */

typedef struct ecp_i_island {
    ecp_i_motion *motions;   /* of all bodies (ecp_i_mover) */
    int *bodies, body_count; /* indices of the island's dynamic bodies */
    ecp_i_pair **pairs;
    int pair_count, unknowns;
    int all; /* patches with those that are left out of the equations, which come last */
    ecp_i_arena *arena;
    /* what counts as zero in a warm start: velocities, scaled, and turns within the step, in rad */
    ecp_real h, noise, turn;
    ecp_real tolerance;
    ecp_real chord; /* of its patches */
    const ecp_world *world;
    int centring;     /* count unknowns from their target in the next Newton step */
    int many;         /* the last Newton step had many solutions (see ecp_i_island_step) */
    int nearest;      /* the rule is ECP_NEAREST: starts keep the ECPs where they can */
    int uncentred;    /* a patch starts from a point that the rule ECP_CENTRED did not choose, */
    int in_vain;      /* or could not find */
    int still;        /* nothing moved in the start */
    int course;       /* how its patches were solved in the last step, together */
    int rests;        /* its bodies begin the step at rest (ecp_i_come_to_rest), */
    ecp_real dropped; /* without this velocity */
    int loose; /* in float: normals are held to the tolerance only (ecp_i_geometry_error), and
                      momentum to the noise of gaps, whatever the loads */
    size_t begin, blocks_at; /* where the memory of a Newton step begins, and that of its blocks */
    ecp_i_tree tree;
} ecp_i_island;

/* without pairs an island is one body, which `motions` begins with, and the patches that it has with half-spaces */
static int ecp_i_body_count(const ecp_i_island *s) { return ECP_I_PAIRS ? s->body_count : 1; }

static ecp_i_motion *ecp_i_mover(const ecp_i_island *s, int i)
{
    return s->motions + (ECP_I_PAIRS ? s->bodies[i] : i);
}

/* From so many unknowns on (piles of 50 bodies) what follows Newton from the warm start comes in another
   order, searches that go round in a circle are stopped, and centring is given up earlier. Large piles take
   many iterations, most of them in vain; small islands other starts solve as quickly, and for one body
   alone nothing changes. In their damped steps momentum counts by ECP_I_SAME_DAMPED_MOMENTUM. */
#define ECP_I_LARGE 1500

static int ecp_i_island_is_large(const ecp_i_island *s)
{
    return ecp_i_body_count(s) > 1 && s->unknowns >= ECP_I_LARGE;
}

static void ecp_i_no_noise(ecp_i_motion *m)
{
    m->noise = m->jitter = 0;
    ECPSIM_MEMSET(m->along, 0, sizeof m->along);
}

/* What the rounding of a gap does to a body it does along the normal and about what is across it, and by the friction
   of that impulse in the other directions: a stack on ice is known to be pushed by far less than its gaps let pass. */
static void ecp_i_add_noise_share(const ecp_i_pair *c, ecp_i_motion *m)
{
    ecp_real mu = ecp_i_min(c->mu, 1), n[3], all;
    int k;
    if (!ECP_I_PAIRS) return;
    for (k = 0; k < 3; k++) n[k] = ecp_i_abs(c->n[k]);
    all = n[0] + n[1] + n[2];
    for (k = 0; k < 3; k++) {
        ecp_real across = ecp_i_min(all - n[k], 1);
        ecp_i_raise(m->along + k, n[k] + mu * (1 - n[k]));
        ecp_i_raise(m->along + k + 3, across + mu * (1 - across));
    }
}

static ecp_real ecp_i_noise_share(const ecp_i_motion *m, int k)
{
    return ECP_I_PAIRS ? m->along[k] : ECP_R(1);
}

/* Velocities that move a body within a step by less than the rounding error of a gap between two
   bodies, or than `tiny` lengths, can not be told from zero. (A half-space's gap is known to its
   increments. But where several gaps are to be closed at once, their rounding errors contradict each
   other and what sticks: the jitter that the other rows of the patch are granted, those of friction as
   far as the projection passes it on.) */
static void ecp_i_pair_noise(const ecp_i_pair *c, ecp_real h, ecp_real tiny)
{
    ecp_real noise = (c->d_noise + tiny * c->L) / h, jitter = c->d_noise / h;
    ecp_i_raise(&c->ma->jitter, jitter);
    ecp_i_raise(&c->mb->jitter, jitter);
    if (ecp_i_moves_a(c)) ecp_i_add_noise_share(c, c->ma);
    if (ecp_i_moves_b(c)) ecp_i_add_noise_share(c, c->mb);
    if (ecp_i_on_plane(c)) return;
    ecp_i_raise(&c->ma->noise, noise);
    ecp_i_raise(&c->mb->noise, noise);
}

static ecp_real ecp_i_largest(int n, const ecp_real *F)
{
    ecp_real worst = 0;
    int i;
    for (i = 0; i < n; i++) {
        ecp_i_worst(&worst, ecp_i_abs(F[i]));
    }
    return worst;
}

/* The largest |F_i|, in the units in which it is to be small, which need not be those of F. error: above the
   rounding floors, which is what a solution is judged by. rest: what Newton might still better, the largest
   with what adding up the impulses rounds taken off the balances of momentum. friction: the rows of it, floors
   included: what rests satisfies them exactly, and what is at its cone's edge is not to be held for their sake. */
typedef struct ecp_i_size {
    ecp_real largest, error, rest, friction;
} ecp_i_size;

/* How far normals and multipliers are off. By that faces overlap at their far ends, and the next step may have its
   ECP there: of a wedge that holds itself by friction no force gets it out again. In double Newton comes down to
   rounding by itself; in float it would be content with a hundred times that. So there normals on half-spaces are
   held to rounding, others to a tenth of the tolerance, where such a solution is found. */
#ifdef ECPSIM_FLOAT
#define ECP_I_STRICT_NORMALS 1
#else
#define ECP_I_STRICT_NORMALS 0
#endif

static ecp_real ecp_i_geometry_error(const ecp_i_island *s, const ecp_i_pair *c, ecp_real size,
                                     ecp_real jitter)
{
    ecp_real granted = jitter * s->h / c->L;
    if (!ECP_I_STRICT_NORMALS || s->loose) return size - granted;
    return ecp_i_on_plane(c) ? 100 * (size - 2 * ECP_I_EPSILON) : 10 * (size - granted);
}

/* How far rounding may have moved the row of a gap. A pair's has the rounding of the poses in it: flush cubes that
   stand in a wall overlap here and there by that, which is nothing to mend. Where there is no load for it, the row
   of a gap below zero is twice the gap. */
static ecp_real ecp_i_gap_noise(const ecp_i_island *s, const ecp_i_pair *c)
{
    ecp_real noise = c->d_noise / (s->h * c->V), d = ecp_i_row_gap(c) / (s->h * c->V);
    if (ecp_i_on_plane(c)) return noise;
    return (c->p[0] > -d ? ECP_R(1) : ECP_R(2)) * ECP_I_POSE_ROUNDING * noise;
}

/* zeros in a vector for the unknowns of what is left out */
static void ecp_i_clear_left_out(const ecp_i_island *s, ecp_real *x)
{
    int i, k;
    for (i = s->pair_count; ECP_I_PAIRS && i < s->all; i++) {
        const ecp_i_pair *c = s->pairs[i];
        for (k = 0; k < c->count; k++) x[c->at + k] = 0;
    }
}

/* the trial motion of a body from its six unknowns, which are its velocity change dv in its units */
static void ecp_i_trial_move(ecp_i_motion *m, ecp_real h, const ecp_real *z, ecp_real dv[6])
{
    ecp_i_scale(m->speed, z, dv);
    ecp_i_scale(m->speed / m->length, z + 3, dv + 3);
    ecp_i_move(m, h, dv);
}

/* what a body's balance of momentum begins with, at its trial motion; the impulses of its patches are added to it */
static void ecp_i_begin_balance(ecp_i_motion *m, ecp_real h, const ecp_real *z)
{
    ecp_real dv[6];
    ecp_i_trial_move(m, h, z, dv);
    ecp_i_scale(m->mass, dv, m->residual);
    ecp_i_sub(m->residual, m->kick, m->residual);
    ecp_i_spin_momentum(m->R0, m->body->inertia, dv + 3, m->residual + 3);
    ecp_i_sub(m->residual + 3, m->kick + 3, m->residual + 3);
    m->floor[0] = ecp_i_norm(m->kick);
    m->floor[1] = ecp_i_norm(m->kick + 3);
    ecp_i_no_noise(m);
}

/* a gap is held to the tolerance times so many radii, however far points move in the step */
#define ECP_I_FAR_RADII 1000

/* P in the unit m V of the lighter of the two bodies, if it is that of a heavy one: what is nothing to that throws the
   other. (The load of some layers of equal bodies is no such thing.) */
static ecp_real ecp_i_light_unit(const ecp_i_pair *c)
{
    ecp_real mass = c->ma->mass, heavy = c->P / c->V;
    if (!ECP_I_PAIRS) return 1;
    if (ecp_i_moves_a(c) && ecp_i_moves_b(c))
        heavy = ecp_i_min(heavy, ecp_i_max(mass, c->mb->mass));
    if (ecp_i_moves_b(c) && (!ecp_i_moves_a(c) || c->mb->mass < mass)) mass = c->mb->mass;
    return heavy > 8 * mass ? heavy / mass : ECP_R(1);
}

/* how far the impulse is in that unit from being none, or a push by what touches; without it F tells */
static ecp_real ecp_i_idle_impulse(const ecp_i_island *s, const ecp_i_pair *c)
{
    ecp_real unit = ecp_i_light_unit(c), noise = ecp_i_gap_noise(s, c), p = unit * c->p[0];
    if (!(unit > 1)) return 0;
    return p < 0 ? -p - noise : ecp_i_min(p, ecp_i_row_gap(c) / (s->h * c->V) - noise);
}

/* how large the rows of a patch are, from `row` on; friction is measured with a rho that does not depend on the load */
static void ecp_i_add_pair_size(const ecp_i_island *s, const ecp_i_pair *c, const ecp_real *row,
                                ecp_i_size *total)
{
    ecp_i_projection q;
    ecp_real jitter = ecp_i_moves_a(c) ? c->ma->jitter : ECP_R(0);
    ecp_real friction[3], size;
    ecp_real gap_weight = ecp_i_max(1, s->h * c->V / (ECP_I_FAR_RADII * c->a->shape.radius));
    int normal = ecp_i_on_plane(c) ? 3 : 4, gap = ecp_i_at_p(c);
    if (ecp_i_moves_b(c)) jitter = ecp_i_max(jitter, c->mb->jitter);
    size = ecp_i_largest(normal, row) - c->n_noise;
    ecp_i_worst(&size, ecp_i_largest(gap - normal, row + normal));
    ecp_i_worst(&total->error, ecp_i_geometry_error(s, c, size, jitter));
    ecp_i_worst(&total->error, gap_weight * (ecp_i_abs(row[gap]) - ecp_i_gap_noise(s, c)));
    if (ECP_I_PAIRS) ecp_i_worst(&total->error, ecp_i_idle_impulse(s, c));
    ecp_i_worst(&total->largest, ecp_i_largest(gap + 1, row));
    if (ecp_i_nf(c) == 0) return;
    ecp_i_cone_project(c, c->rho, &q);
    ecp_i_friction_rows(c, &q, friction);
    size = ecp_i_largest(ecp_i_nf(c), friction);
    ecp_i_worst(&total->largest, size);
    ecp_i_worst(&total->friction, size);
    /* one patch on a half-space has nothing that contradicts it: in float, in short steps, it was held by
       what its gap's rounding granted */
    if (s->pair_count == 1 && ecp_i_on_plane(c)) jitter = 0;
    ecp_i_worst(&total->error, size - (1 - q.taken) * jitter / c->V);
}

/* the rows of a body's balance, once all impulses are in it, and how large they are */
static void ecp_i_balance_rows(const ecp_i_island *s, const ecp_i_motion *m, ecp_real *row,
                               ecp_i_size *total)
{
    ecp_real unit = m->mass * m->speed, noise = ECP_I_PAIRS ? m->noise / m->speed : ECP_R(0);
    int k, r;
    if (noise > 0) {
        /* but what the loads do in the step is told from nothing, if it can be: it adds up */
        ecp_real moved = ecp_i_norm(m->free) / m->speed;
        if (moved > 0 && !s->loose) noise = ecp_i_min(noise, moved / 64);
    }
    for (k = 0; k < 2; k++, row += 3) {
        ecp_real scale = k ? unit * m->length : unit;
        ecp_real floor = 16 * ECP_I_EPSILON * m->floor[k] / scale, size;
        for (r = 0; r < 3; r++) {
            ecp_real granted = noise * ecp_i_noise_share(m, 3 * k + r);
            row[r] = m->residual[3 * k + r] / scale;
            ecp_i_worst(&total->error, ecp_i_abs(row[r]) - floor - granted);
        }
        size = ecp_i_largest(3, row);
        ecp_i_worst(&total->largest, size);
        ecp_i_worst(&total->rest, size - floor / 8);
    }
}

/* F at z = (six scaled velocity changes a body, then the patches), and how large it is (ecp_i_problem) */
static void ecp_i_island_residual(void *self, const ecp_real *z, ecp_real relax, ecp_real *F,
                                  ecp_i_size *total)
{
    ecp_i_island *s = (ecp_i_island *)self;
    int i;
    total->largest = total->error = total->friction = 0;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_begin_balance(ecp_i_mover(s, i), s->h, z + 6 * i);
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_CONTINUATION) c->relax = relax;
        if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_CHORD) c->chord = s->chord;
        ecp_i_pair_evaluate(c, z + c->at, s->h);
        ecp_i_pair_residual(c, z + c->at, s->h, F + c->at);
        ecp_i_pair_noise(c, s->h, 0);
        if (ecp_i_moves_a(c)) ecp_i_wrench(c, c->ma, c->ra, 1);
        if (ecp_i_moves_b(c)) ecp_i_wrench(c, c->mb, c->rb, -1);
    }
    ecp_i_clear_left_out(s, F);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_add_pair_size(s, s->pairs[i], F + s->pairs[i]->at, total);
    }
    total->rest = total->largest;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_balance_rows(s, ecp_i_mover(s, i), F + 6 * i, total);
    }
}

/* the Newton block of a patch with this many unknowns */
static void ecp_i_carve_block(ecp_i_arena *arena, int count, int bodies, ecp_i_pair *c)
{
    int rows = count + ecp_i_seats_of(bodies);
    int *ints = ecp_i_take_ints(arena, (3 + ECP_I_PAIRS) * count);
    ecp_real *block = ecp_i_take_reals(arena, rows, rows + 1);
    if (!block) return;
    c->block = block;
    c->row_tag = ints;
    c->col_tag = ints + count;
    c->col_order = ints + 2 * count;
}

/* The tree of an island of n bodies: what the order needs, and the vectors of a solve. */
static void ecp_i_carve_tree(ecp_i_arena *arena, int n, ecp_i_tree *t, ecp_i_graph *g)
{
    int words = (n + ECP_I_WORD - 1) / ECP_I_WORD;
    t->fronts = (ecp_i_front *)ecp_i_take(arena, (size_t)n, sizeof(ecp_i_front));
    t->v = ecp_i_take_reals(arena, 6, n);
    t->u = NULL;
    if (!ECP_I_PAIRS) return;
    t->u = ecp_i_take_reals(arena, 6, n);
    t->slot = ecp_i_take_ints(arena, n);
    t->ints = ecp_i_take_ints(arena, 6 * n);
    g->mass = ecp_i_take_reals(arena, n, 1);
    g->degree = ecp_i_take_ints(arena, n);
    g->rank = ecp_i_take_ints(arena, n);
    g->held = ecp_i_take_ints(arena, n);
    g->fronts = (ecp_i_front *)ecp_i_take(arena, (size_t)n, sizeof(ecp_i_front));
    g->bits = (unsigned *)ecp_i_take(arena, (size_t)n * (size_t)words, sizeof(unsigned));
}

/* The order of elimination, and the front at which each patch is assembled: the first one of its
   bodies. Sets `planned` if the memory suffices. */
static void ecp_i_tree_plan(ecp_i_island *s)
{
    ecp_i_tree *t = &s->tree;
    ecp_i_graph g;
    int n = ecp_i_body_count(s), words = (n + ECP_I_WORD - 1) / ECP_I_WORD, i;
    ecp_i_carve_tree(s->arena, n, t, &g);
    if (s->arena->overflow) return;
    t->h = s->h;
    t->planned = 1;
    if (!ECP_I_PAIRS) {
        ecp_i_front *alone = t->fronts;
        ECPSIM_MEMSET(alone, 0, sizeof *alone);
        for (i = s->pair_count - 1; i >= 0; i--) {
            ecp_i_pair *c = s->pairs[i];
            c->next_here = alone->pairs;
            alone->pairs = c;
        }
        return;
    }
    ECPSIM_MEMSET(g.bits, 0, (size_t)(n * words) * sizeof(unsigned));
    ECPSIM_MEMSET(g.fronts, 0, (size_t)n * sizeof(ecp_i_front));
    for (i = 0; i < n; i++) {
        g.mass[i] = ecp_i_mover(s, i)->mass;
        g.held[i] = 0;
    }
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        if (!ecp_i_moves_a(c) || !ecp_i_moves_b(c)) {
            g.held[(ecp_i_moves_a(c) ? c->ma : c->mb)->at / 6]++;
            continue;
        }
        ecp_i_set_bit(g.bits + words * (c->ma->at / 6), c->mb->at / 6, 1);
        ecp_i_set_bit(g.bits + words * (c->mb->at / 6), c->ma->at / 6, 1);
    }
    ecp_i_minimum_degree(s->arena, n, &g);
    t->planned = !s->arena->overflow;
    if (!t->planned) return;
    ecp_i_postorder(n, &g, t->fronts);
    for (i = 0; i < n; i++) g.rank[t->fronts[i].body] = i;
    for (i = s->pair_count - 1; i >= 0; i--) {
        ecp_i_pair *c = s->pairs[i];
        int a = ecp_i_moves_a(c) ? g.rank[c->ma->at / 6] : n;
        int b = ecp_i_moves_b(c) ? g.rank[c->mb->at / 6] : n;
        ecp_i_front *f = t->fronts + (a < b ? a : b);
        c->next_here = f->pairs;
        f->pairs = c;
    }
}

/* the Newton blocks of all patches, as large as they can be */
static void ecp_i_carve_blocks(const ecp_i_island *s, ecp_i_arena *arena)
{
    int i;
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_i_carve_block(arena, c->count, ecp_i_moves_a(c) + ecp_i_moves_b(c), c);
    }
}

/* The memory of a Newton step, taken when the first one is made: a start that is a solution needs
   none of it. */
static void ecp_i_island_carve(ecp_i_island *s)
{
    ecp_i_tree_plan(s);
    s->blocks_at = s->arena->used;
    s->tree.stack = s->arena->top;
}

/* The most that the fronts can take, in reals: patches leave 8 rows as in ecp_i_tree_reals, and what
   a front passes on has the rank of its width. */
static size_t ecp_i_tree_most(const ecp_i_tree *t, int n)
{
    size_t lasting = 0, passed = 0, most = 0;
    int k, i;
    for (k = 0; k < n; k++) {
        const ecp_i_front *f = t->fronts + k;
        const ecp_i_pair *c;
        size_t u = (size_t)ecp_i_width(f), rows = 6, from = 0, pass = u * (3 * u + 2), now;
        for (c = f->pairs; c; c = c->next_here) rows += 8;
        for (i = ecp_i_child(f); i >= 0; i = t->fronts[i].next) {
            size_t w = (size_t)ecp_i_width(t->fronts + i);
            rows += w;
            from += w * (3 * w + 2);
        }
        lasting += (19 + rows) * (7 + u) + u + 18; /* 12 for rounding up */
        if (ECP_I_PAIRS) lasting += 9 * u + 24 + rows * (6 + u);
        now = passed + (rows + 6 + u) * (7 + u) + pass;
        if (now > most) most = now;
        passed += pass - from;
    }
    return lasting + most;
}

/* After an overflow, how large the arena should have been for the island's Newton steps; where there
   was not even room to plan them, for that. */
static size_t ecp_i_island_wants(const ecp_i_island *s)
{
    ecp_i_arena arena = ecp_i_arena_over(NULL, 0);
    size_t n = (size_t)ecp_i_body_count(s);
    ecp_i_tree tree;
    ecp_i_graph g;
    if (s->tree.planned) {
        arena.used = s->blocks_at;
        ecp_i_take(&arena, ecp_i_tree_most(&s->tree, ecp_i_body_count(s)), sizeof(ecp_real));
    } else {
        arena.used = s->begin;
        ecp_i_carve_tree(&arena, ecp_i_body_count(s), &tree, &g);
        ecp_i_take(&arena, n * n, sizeof(int));
    }
    ecp_i_carve_blocks(s, &arena);
    return arena.used > s->arena->wanted ? arena.used : s->arena->wanted;
}

/* With compliance any solution is the only one. Whether there are many is asked again then, by the first centring
   step, which has none; but not in float, where it is mostly noise in what must be damped, and centring
   for it costs solutions. */
#ifdef ECPSIM_FLOAT
#define ECP_I_ASKS_AGAIN 0
#else
#define ECP_I_ASKS_AGAIN 1
#endif

/* Where nothing moves, what is rounding in the normal of a flat face on a half-space is not mended: a
   quaternion has no room for so small a turn and takes twice as much, and the next step would turn back. */
static ecp_real ecp_i_normal_floor(const ecp_i_island *s, const ecp_i_pair *c)
{
    return s->still && ecp_i_on_plane(c) ? 2 * ECP_I_EPSILON : ECP_R(0);
}

/* The step from the velocities in s->tree.v and the forces that the fronts have found. Returns 0 if it is not
   finite. */
static int ecp_i_island_recover(const ecp_i_island *s, const ecp_real *z, ecp_real *dz)
{
    const ecp_real *v = s->tree.v;
    int i, n = 6 * ecp_i_body_count(s);
    ecp_i_copy(n, v, dz);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_i_block_recover(c, z + c->at, v + (ECP_I_PAIRS && ecp_i_moves_a(c) ? c->ma->at : 0),
                            v + (ecp_i_moves_b(c) ? c->mb->at : 0), s->h,
                            ECP_I_CENTRING && s->centring, dz + c->at);
    }
    ecp_i_clear_left_out(s, dz);
    return ecp_i_all_finite(s->unknowns, dz);
}

/* what ecp_i_island_turn compares a trial point with: the tangents where the Newton step to it is made */
static void ecp_i_note_tangents(const ecp_i_pair *c)
{
    if (ecp_i_on_plane(c)) return;
    ecp_i_copy3(c->t, c->on_b->last_t);
    ecp_i_copy3(c->o, c->on_b->last_o);
    c->on_b->last_axis = c->on_b->axis;
}

/* Friction is written along tangents, and z, the point of the last residual, may have others than the point of the last
   Newton step (ecp_i_tangents): the same friction along those. */
static int ecp_i_island_turn(void *self, ecp_real *z)
{
    const ecp_i_island *s = (const ecp_i_island *)self;
    ecp_real friction[3];
    int i, turned = 0;
    for (i = 0; ECP_I_PAIRS && i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        ecp_real *y = z + c->at + ecp_i_at_p(c) + 1;
        if (ecp_i_nf(c) == 0 || ecp_i_on_plane(c) || c->on_b->axis == c->on_b->last_axis) continue;
        ecp_i_scale(c->e[0] * y[0], c->on_b->last_t, friction);
        ecp_i_axpy(friction, c->e[1] * y[1], c->on_b->last_o, friction);
        y[0] = ecp_i_dot(friction, c->t) / c->e[0];
        y[1] = ecp_i_dot(friction, c->o) / c->e[1];
        turned++;
    }
    return turned;
}

/* The Newton step at the point of the last residual. With a compliance the gap, the slip and the tilt of
   a contact give way to the change of its impulse and its pressure centre, so that none of these can
   become large for the sake of a small residual. Returns 0 if the step is not finite, or if the memory
   does not suffice. */
static int ecp_i_island_step(void *self, const ecp_real *z, const ecp_real *F, ecp_real fine,
                             ecp_real compliance, ecp_real *dz)
{
    ecp_i_island *s = (ecp_i_island *)self;
    ecp_i_tree *t = &s->tree;
    int i, n = 6 * ecp_i_body_count(s);
    if (!t->fronts && !s->arena->overflow) ecp_i_island_carve(s);
    if (s->arena->overflow) return 0;
    ecp_i_release(s->arena, s->blocks_at, t->stack);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        c->compliance = compliance;
        ecp_i_note_tangents(c);
        ecp_i_block_condense(c, z + c->at, ECP_I_CENTRING && s->centring);
        ecp_i_carve_block(s->arena, c->ny, ecp_i_moves_a(c) + ecp_i_moves_b(c), c);
        if (s->arena->overflow) return 0;
        ecp_i_block_fill(c, z + c->at, F + c->at, s->h, ECP_I_CENTRING && s->centring,
                         ecp_i_normal_floor(s, c));
        ecp_i_block_eliminate(c);
        ecp_i_block_pack(s->arena, c);
    }
    for (i = 0; i < n; i++) dz[i] = -F[i];
    t->same = ecp_i_max(ECP_I_FINEST_CONSTRAINT, ecp_i_min(ECP_I_SAME_CONSTRAINT, fine));
    if (ECP_I_PAIRS) t->damped = compliance > 0 && ecp_i_island_is_large(s);
    if (!ecp_i_tree_solve(t, s->arena, ecp_i_body_count(s), s->motions, s->bodies, dz)) return 0;
    s->many = t->many > 0 || (ECP_I_ASKS_AGAIN && compliance > 0);
    return ecp_i_island_recover(s, z, dz);
}

/* what counts as a load, in units P, and how far inside its cone an impulse is that sticks, in parts of the radius */
#define ECP_I_LOADED ECP_R(1e-9)
#define ECP_I_INSIDE ECP_R(1e-6)

/* lowers *first to e; 0 is none yet */
static void ecp_i_sooner(ecp_real e, ecp_real *first)
{
    if (*first == 0 || e < *first) *first = e;
}

/* The least e > 0 at which an impulse z + e dz ends, or one that sticks comes to the rim of its cone; 0: there is
   none. Of a search along impulses that drift (ecp_i_take_stride). With p = (p_n, y) the latter is the root of
   |y + e dy|^2 = mu^2 (p_n + e dp_n)^2. */
static ecp_real ecp_i_island_event(const void *self, const ecp_real *z, const ecp_real *dz)
{
    const ecp_i_island *s = (const ecp_i_island *)self;
    ecp_real first = 0;
    int i, k;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        int at = c->at + ecp_i_at_p(c);
        const ecp_real *p = z + at, *d = dz + at;
        ecp_real radius2 = c->mu * c->mu * p[0] * p[0], a = -c->mu * c->mu * d[0] * d[0],
                 b = -c->mu * c->mu * p[0] * d[0], inside = radius2, e;
        if (!(p[0] > ECP_I_LOADED)) continue;
        if (d[0] < 0) ecp_i_sooner(-p[0] / d[0], &first);
        for (k = 1; k <= ecp_i_nf(c); k++) {
            a += d[k] * d[k];
            b += p[k] * d[k];
            inside -= p[k] * p[k];
        }
        /* a e^2 + 2 b e - inside = 0 */
        if (!(inside > ECP_I_INSIDE * radius2)) continue;
        e = b * b + a * inside;
        if (!(e >= 0)) continue;
        b += ecp_i_sqrt(e);
        if (b > 0) ecp_i_sooner(inside / b, &first);
    }
    return first;
}

/* The same with the elimination of the last one, which was made at a point near by: a simplified Newton step, for a
   fraction of the work. Of one body alone there is none: all that is saved there is a small block. */
static int ecp_i_island_again(void *self, const ecp_real *z, const ecp_real *F, ecp_real *dz)
{
    ecp_i_island *s = (ecp_i_island *)self;
    int i, n = 6 * ecp_i_body_count(s);
    if (n < 12) return 0;
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_i_note_tangents(c);
        if (!ecp_i_block_again(c, z + c->at, F + c->at, s->h, ecp_i_normal_floor(s, c), dz + c->at))
            return 0;
    }
    for (i = 0; i < n; i++) dz[i] = -F[i];
    if (!ecp_i_tree_again(&s->tree, s->arena, n / 6, dz)) return 0;
    return ecp_i_island_recover(s, z, dz);
}
/* >>newton ================================================================================
   The one globalisation: damped Newton on the semismooth system F(z) = 0, for the step's problem
   and for ecp_mcp_solve alike. */

typedef struct ecp_i_effort {
    ecp_i_size size; /* of the last residual */
    int iterations, evaluations, fallbacks;
    int most; /* iterations that may be made; -1: more were wanted */
} ecp_i_effort;

typedef struct ecp_i_problem {
    void *self;
    int n;
    /* F[n] at z, of the problem relaxed by so much (0: not at all), and its size */
    void (*residual)(void *self, const ecp_real *z, ecp_real relax, ecp_real *F, ecp_i_size *size);
    /* the Newton step at the z of the last residual; 0: none. fine: 1, or the relative difference
       down to which equations are to be told apart. compliance: damps it, 0: not at all */
    int (*step)(void *self, const ecp_real *z, const ecp_real *F, ecp_real fine,
                ecp_real compliance, ecp_real *dz);
    /* where unknowns at the z of the last residual mean something else than where the last Newton step was made: the
       same as they meant there, in the new terms. Returns how many these are. NULL: none */
    int (*turn)(void *self, ecp_real *z);
    /* the same with the derivative of the last one, that was made near by; 0: none. NULL: never */
    int (*again)(void *self, const ecp_real *z, const ecp_real *F, ecp_real *dz);
    /* how many times dz it is from z to the first event, or 0. NULL: there are none */
    ecp_real (*event)(const void *self, const ecp_real *z, const ecp_real *dz);
    /* the k-th start (0: warm, 1 and 2: geometric, then disturbed ones; ECP_I_START_MOVES_ON and ECP_I_START_HELD, asked
       for where there are velocities); 0: there is none. Of the warm one 2 says that nothing moves in it */
    int (*start)(void *self, int k, ecp_real *z);
    /* solves the problem from its warm start by fewer equations first, or NULL */
    int (*gather)(void *self, const struct ecp_i_problem *p, const ecp_options *o, ecp_real *z,
                  ecp_i_effort *effort);
    /* betters a z at which Newton has stalled, or NULL */
    void (*repair)(void *self, ecp_real *z);
    /* is what solves the equations at the last residual a solution to take? or NULL: always */
    int (*valid)(void *self);
    /* takes this share of all that moves the bodies, or NULL; with none, the start number
       ECP_I_START_AT_REST is a solution or close to one */
    void (*load)(void *self, ecp_real share);
    ecp_real *F, *dz, *trial, *drift, *kept; /* n each */
    ecp_real *stalled; /* the same; NULL: no working set, no continuation in haste */
    int velocities; /* so many unknowns come first that say how velocities change; 0: there are none */
    int large;      /* ecp_i_island_is_large */
    int hurries;    /* the chain ends with the first three starts (ecp_i_hurries) */
    int patient;    /* else a search that crawls is given up (ECP_I_STALE) */
    int gathered; /* the last step was solved by p->gather: so is this one, if it can be */
    int calm;     /* no merit above the first is let pass */
} ecp_i_problem;

/* nothing done yet, and what options.max_total_iterations leaves after so many iterations elsewhere */
static ecp_i_effort ecp_i_effort_after(const ecp_options *o, int iterations)
{
    ecp_i_effort effort;
    effort.size.largest = 0;
    effort.iterations = effort.evaluations = effort.fallbacks = 0;
    effort.most = 0x7fffffff;
    if (o->max_total_iterations > 0) {
        effort.most =
            iterations < o->max_total_iterations ? o->max_total_iterations - iterations : 0;
    }
    return effort;
}

/* did that option not matter here, and does what was done here not matter for what it leaves to others? */
static int ecp_i_unbound(const ecp_options *o, const ecp_i_effort *effort)
{
    return o->max_total_iterations == 0 || (effort->iterations == 0 && effort->most > 0);
}

/* may this way out be tried? */
static int ecp_i_may(const ecp_options *o, int fallback)
{
    return (o->fallbacks & (ECPSIM_FALLBACKS)&fallback) != 0;
}

/* are there no iterations left? */
static int ecp_i_spent(const ecp_i_effort *effort) { return effort->iterations >= effort->most; }

static ecp_real ecp_i_merit(int n, const ecp_real *F)
{
    ecp_real sum = 0;
    int i;
    for (i = 0; i < n; i++) sum += F[i] * F[i];
    return sum / 2;
}

/* The residual that Newton aims at, and the one that a warm start must have to need no iteration:
   far below the tolerance, but not below rounding. */
static ecp_real ecp_i_aim(ecp_real tolerance)
{
    return ecp_i_max(tolerance / 10000, ECP_I_EPSILON / 2);
}

static ecp_real ecp_i_content(ecp_real tolerance)
{
    return ecp_i_max(tolerance / 100, 4 * ECP_I_EPSILON);
}

static int ecp_i_is_large(const ecp_i_problem *p) { return ECP_I_PAIRS && p->large; }
static int ecp_i_in_haste(const ecp_i_problem *p) { return ECP_I_PAIRS && p->hurries; }
static int ecp_i_is_patient(const ecp_i_problem *p, ecp_real relax)
{
    return !ecp_i_in_haste(p) && (relax > 0 || p->patient);
}

/* how many of the last merits a new one may compare itself with */
#define ECP_I_MEMORY 4

/* the line search gives up below the first part of a step, which then is damped more; below the second
   of one that can not be damped more */
#define ECP_I_SHORT_STEP ECP_R(0.02)
#define ECP_I_SHORTEST_STEP ECP_R(1e-5)

/* A search whose merit has not come a tenth below its lowest for so many iterations goes round in a
   circle: after each good step a bad one is let pass, because of one as bad before the good one. It
   crawls if its compliance is as large as this, and ends, as more iterations seldom help then; but not of a
   relaxed problem, nor of three bodies and more unless in haste, where it may be the only way, nor if
   there is no other start. */
#define ECP_I_RESTARTS ((ECPSIM_FALLBACKS) & ~(ECP_FALLBACK_SUBSTEPS | ECP_FALLBACK_CHORD))
/* (large islands, which have pairs, look for circles as well) */
#define ECP_I_GIVES_UP (ECP_I_PAIRS || ECP_I_RESTARTS != 0)
#define ECP_I_STALE 8
#define ECP_I_STALE_COMPLIANCE ECP_R(0.1)

/* Merits up to this one are let pass at first, a quarter of it after each iteration: near the kinks of
   a semismooth system a step that brings the right set of active constraints may raise the merit. */
#define ECP_I_SLACK ECP_R(1e-2)

/* A step that moves no unknown by this part of the tolerance mends nothing that is above it, and nor would the ones
   after it. In float so little is rounding, and says nothing. */
#ifdef ECPSIM_FLOAT
#define ECP_I_STANDSTILL ECP_R(0.0)
#else
#define ECP_I_STANDSTILL ECP_R(0.02)
#endif

/* Compliances in the units of the rows: the first one that is tried, the largest, what a stride needs at
   least, and what is none. */
#ifdef ECPSIM_FLOAT
#define ECP_I_FIRST_COMPLIANCE ECP_R(1e-2)
#define ECP_I_STRIDE_COMPLIANCE ECP_R(1e-4)
#define ECP_I_NO_COMPLIANCE ECP_R(1e-4)
#else
#define ECP_I_FIRST_COMPLIANCE ECP_R(1e-3)
#define ECP_I_STRIDE_COMPLIANCE ECP_R(1e-6)
#define ECP_I_NO_COMPLIANCE ECP_R(1e-7)
#endif
#define ECP_I_MOST_COMPLIANCE ECP_R(10.0)

/* a search whose steps are damped may take as many times its limit, with many unknowns twice that */
#define ECP_I_DAMPED_LIMIT 4

/* strides begin at residuals below the first, are not longer than the second, and do not raise the
   merit above the third; so many of them a search may take where no part of the damped step will do,
   which is enough to grow a millionfold */
#define ECP_I_STALLED ECP_R(1e-3)
#define ECP_I_LONGEST_STRIDE ECP_R(1.0)
#define ECP_I_STRIDE_MERIT ECP_R(1e-4)
#define ECP_I_STRIDES 10

/* Every other stride goes to this times the way to an event at the most; with all of them a search may never get past
   events of loads that are noise. In float most are, so none is looked at there (flush crates on lifts would not come
   to rest). */
#define ECP_I_BEYOND_EVENT ECP_R(1.001)
#ifdef ECPSIM_FLOAT
#define ECP_I_EVENTS 0
#else
#define ECP_I_EVENTS ECP_I_PAIRS
#endif

/* the residual from which on a warm start has a rival */
#define ECP_I_BAD_START ECP_R(1e-2)

/* a search in progress: ecp_i_aim and ecp_i_content; the last merits; the compliance; the length of the last
   stride, and what it was to mend; the lowest merit, and for how many iterations none was lower; how many strides
   it took where no part of a step would do, and iterations for the sake of friction alone; whether the last stride
   was one that goes to an event */
typedef struct ecp_i_search {
    ecp_real aim, content, merits[ECP_I_MEMORY], slack, merit, fine, compliance, stride, miss,
        lowest;
    int age, strides, granted, to_event;
} ecp_i_search;

static void ecp_i_evaluate(const ecp_i_problem *p, const ecp_real *z, ecp_real relax,
                           ecp_i_effort *effort)
{
    p->residual(p->self, z, relax, p->F, &effort->size);
    effort->evaluations++;
}

/* the residual at z + t dz, which p->trial becomes */
static void ecp_i_try(const ecp_i_problem *p, const ecp_real *z, ecp_real t, ecp_real relax,
                      ecp_i_search *s, ecp_i_effort *effort)
{
    int i;
    for (i = 0; i < p->n; i++) p->trial[i] = z[i] + t * p->dz[i];
    ecp_i_evaluate(p, p->trial, relax, effort);
    if (ECP_I_PAIRS && ECP_I_FRICTION && p->turn && p->turn(p->self, p->trial) > 0)
        ecp_i_evaluate(p, p->trial, relax, effort);
    s->merit = ecp_i_merit(p->n, p->F);
}

/* Is a residual worse than one that was well below the tolerance? */
static int ecp_i_is_worse(const ecp_i_size *was, const ecp_i_size *now, ecp_real tolerance,
                          const ecp_i_search *s)
{
    return was->error <= s->content && now->error > was->error && now->largest > was->largest &&
           (!ECP_I_FRICTION || was->friction <= tolerance);
}

/* The non-monotone Armijo rule along dz. Returns the part of the step that is taken, or 0. */
static ecp_real ecp_i_line_search(const ecp_i_problem *p, const ecp_real *z, ecp_real tolerance,
                                  ecp_real relax, ecp_i_search *s, ecp_i_effort *effort)
{
    const ecp_i_size was = effort->size, *now = &effort->size;
    ecp_real best = s->slack, t = 1;
    ecp_real shortest =
        s->compliance < ECP_I_MOST_COMPLIANCE ? ECP_I_SHORT_STEP : ECP_I_SHORTEST_STEP;
    int i;
    if (ECP_I_STANDSTILL > 0 && was.error > tolerance &&
        ecp_i_largest(p->n, p->dz) < tolerance * ECP_I_STANDSTILL)
        return 0;
    for (i = 0; i < ECP_I_MEMORY; i++) best = ecp_i_max(best, s->merits[i]);
    s->slack /= 4;
    for (; t >= shortest; t /= 2) {
        ecp_i_try(p, z, t, relax, s, effort);
        if (now->error <= tolerance && !ecp_i_is_worse(&was, now, tolerance, s)) return t;
        if (was.error <= tolerance) return 0;
        if (s->merit <= (1 - ECP_R(2e-4) * t) * best) return t;
    }
    return 0;
}

/* Where damped steps do not lower the residual any more, or none is taken, what is left of it is most often a
   small contradiction: two constraints that say almost the same, as in a chain of bodies between two walls,
   and forces that drift by contradiction / compliance in each step, until one of them ends, with its
   contact or with sticking, and the contradiction with it. Follows that drift in strides: four times as
   long as the last, or to where the secant of two strides' contradictions vanishes, back if they
   differ in sign; where bodies meet, every other one no further than just beyond the first contact that ends or begins
   to slip.
   (Two at once would each undo what the other has mended, and rows of dominoes go round in a circle.) Damped
   steps then mend the other rows. */
static void ecp_i_take_stride(const ecp_i_problem *p, const ecp_real *z, ecp_real relax,
                              ecp_i_search *s, ecp_i_effort *effort)
{
    ecp_real size = ecp_i_largest(p->n, p->dz), miss = size * s->compliance, along = 0;
    int i;
    ecp_i_copy(p->n, z, p->trial);
    if (!(size > 0)) return;
    for (i = 0; i < p->n && s->stride > 0; i++) along += p->dz[i] * p->drift[i];
    if (along < 0) {
        s->stride *= miss / (miss + s->miss);
    } else if (s->stride > 0 && s->miss > ECP_R(1.5) * miss) {
        s->stride *= ecp_i_min(4, miss / (s->miss - miss));
    } else {
        s->stride = 4 * (s->stride > 0 ? s->stride : size);
    }
    s->stride = ecp_i_min(s->stride, ECP_I_LONGEST_STRIDE);
    if (ECP_I_EVENTS && p->event) {
        ecp_real event = size * p->event(p->self, z, p->dz);
        s->to_event = !s->to_event;
        if (s->to_event && event > 0) s->stride = ecp_i_min(s->stride, ECP_I_BEYOND_EVENT * event);
    }
    for (i = 0; i < 10; i++) {
        ecp_i_try(p, z, s->stride / size, relax, s, effort);
        if (s->merit <= ECP_I_STRIDE_MERIT) break;
        s->stride /= 2;
    }
    s->miss = miss;
    ecp_i_raise(&s->compliance, ECP_I_STRIDE_COMPLIANCE);
    for (i = 0; i < ECP_I_MEMORY; i++) s->merits[i] = s->merit;
    ecp_i_copy(p->n, p->dz, p->drift);
}

/* Does the search go round in a circle? Notes the merit of this iteration. */
static int ecp_i_circles(ecp_i_search *s)
{
    s->age++;
    if (s->merit < ECP_R(0.9) * s->lowest) {
        s->lowest = s->merit;
        s->age = 0;
    }
    return s->age >= ECP_I_STALE;
}

/* are all rows at rounding, so that another iteration would only stir it? Momentum may be off by what its
   sum rounds, which in a tall stack is more than there is to be gained. */
static int ecp_i_at_rounding(const ecp_i_size *size, const ecp_i_search *s)
{
    return size->error <= s->aim && size->rest <= s->content / 8;
}

/* the start of several bodies that move on by the impulses of their last step (ecp_i_island_start) */
#define ECP_I_START_MOVES_ON 11

/* the start of what stands still, if friction can hold it (ecp_i_hold), and whether there is one */
#define ECP_I_START_HELD 12
#define ECP_I_HOLDS (ECP_I_PAIRS && ((ECPSIM_FALLBACKS)&ECP_FALLBACK_GEOMETRIC) != 0)

/* Starts that may be better than the warm one, z, whose residual is at hand. That of bodies that move on together, where
   it is a solution to the tolerance (taken where it was only better it kept crates in float from coming to rest). And
   the velocities of a warm start balance its impulses, but a body that is held takes up in its impulses what is new in a
   step (a push, for one), and its velocities stay as they were: where that start is the better of two bad ones it
   becomes z. What is wrong with velocities weighs more than the residual says, as it is multiplied by what a stack
   carries. Returns 1 if the bodies move on. */
static int ecp_i_better_start(const ecp_i_problem *p, ecp_real tolerance, ecp_real *z,
                              ecp_i_effort *effort)
{
    ecp_real was = effort->size.largest, error = effort->size.error;
    if (p->velocities == 0) return 0;
    if (ECP_I_PAIRS && p->start(p->self, ECP_I_START_MOVES_ON, p->trial)) {
        ecp_i_evaluate(p, p->trial, 0, effort);
        if (effort->size.error <= ecp_i_min(tolerance, error)) {
            ecp_i_copy(p->n, p->trial, z);
            return 1;
        }
        p->start(p->self, 0, z);
        ecp_i_evaluate(p, z, 0, effort);
    }
    if (was < ECP_I_BAD_START) return 0;
    ecp_i_copy(p->n, z, p->trial);
    ECPSIM_MEMSET(z, 0, (size_t)p->velocities * sizeof(ecp_real));
    ecp_i_evaluate(p, z, 0, effort);
    if (effort->size.largest < was) return 0;
    ecp_i_copy(p->n, p->trial, z);
    ecp_i_evaluate(p, z, 0, effort);
    return 0;
}

/* how many steps at most repeat one with its derivative, and by what the first of them must be expected to lower the
   residual: it costs a quarter of a Newton step */
#define ECP_I_REPEATS 6
#define ECP_I_REPEAT_RATIO ECP_R(0.25)

/* After a whole Newton step that has lowered what is left from `before`: another one with the same derivative, and
   more of them where four would come down to rounding. The error of such a step is what it moves times what the
   iterates have moved since the derivative was taken, so it lowers the residual by twice the ratio by which the Newton
   step has. One that does not halve it is taken back, and Newton goes on. */
static void ecp_i_repeat(const ecp_i_problem *p, ecp_real before, ecp_real relax, ecp_real *z,
                         ecp_i_search *s, ecp_i_effort *effort)
{
    const ecp_i_size *now = &effort->size;
    ecp_real ratio = 2 * now->rest / before, rest = now->rest, merit = s->merit;
    int k, most = rest * ratio * ratio * ratio * ratio <= s->content / 8 ? ECP_I_REPEATS : 1;
    if (!ECP_I_PAIRS || !p->again || !(ratio <= ECP_I_REPEAT_RATIO)) return;
    for (k = 0; k < most && !ecp_i_at_rounding(now, s); k++) {
        if (!p->again(p->self, z, p->F, p->dz)) return;
        ecp_i_try(p, z, 1, relax, s, effort);
        if (!(2 * now->rest <= rest)) {
            s->merit = merit;
            ecp_i_evaluate(p, z, relax, effort);
            return;
        }
        rest = now->rest;
        merit = s->merit;
        ecp_i_copy(p->n, p->trial, z);
    }
}

/* is a warm start left as it is? (ecp_i_newton) */
static int ecp_i_start_will_do(const ecp_i_size *size, int warm, ecp_real tolerance,
                               const ecp_i_search *s)
{
    ecp_real enough = warm > 1 ? tolerance : s->content;
    return warm && size->error <= enough && (!ECP_I_FRICTION || size->friction <= enough);
}

/* the search before its first iteration, with the residual at hand */
static void ecp_i_begin_search(const ecp_i_problem *p, ecp_i_search *s)
{
    int k;
    s->merit = s->lowest = ecp_i_merit(p->n, p->F);
    for (k = 0; k < ECP_I_MEMORY; k++) s->merits[k] = s->merit;
    s->slack = ECP_I_PAIRS && p->calm ? ECP_R(0) : ECP_I_SLACK;
    s->fine = 1;
    s->compliance = s->stride = s->miss = 0;
    s->age = s->strides = s->granted = s->to_event = 0;
}

/* Steps of which no part will do are damped more; returns how many iterations that may take in all. */
static int ecp_i_damp(const ecp_i_problem *p, ecp_i_search *s, int limit)
{
    int times = (ecp_i_is_large(p) ? 2 : 1) * ECP_I_DAMPED_LIMIT;
    s->compliance = s->compliance > 0 ? 10 * s->compliance : ECP_I_FIRST_COMPLIANCE;
    return limit > 0x7fffffff / times ? 0x7fffffff : times * limit;
}

/* After the part t of a step: steps are damped less where it helped, more where it did harm. */
static void ecp_i_adapt_compliance(const ecp_i_size *was, const ecp_i_size *now, ecp_real t,
                                   ecp_real tolerance, ecp_i_search *s)
{
    if (now->error <= tolerance || 2 * now->error <= was->error) {
        /* with the residual, where whole steps are taken, so that they become Newton's again */
        ecp_real part =
            t < 1 || 4 * now->error > was->error ? ECP_R(0.25) : now->error / was->error;
        s->compliance = s->compliance < ECP_I_NO_COMPLIANCE
                            ? ECP_R(0)
                            : s->compliance * ecp_i_max(part, ECP_R(0.01));
    } else if (now->error > 2 * was->error) {
        s->compliance *= 4;
    }
}

/* Would another iteration not halve what is below the tolerance? Friction that the floor grants gets one more. */
static int ecp_i_is_enough(const ecp_i_size *was, const ecp_i_size *now, ecp_real tolerance,
                           ecp_i_search *s)
{
    return now->error <= tolerance && 2 * now->largest > was->largest &&
           (now->error <= s->aim || 2 * now->error > was->error) &&
           (!ECP_I_FRICTION || now->friction <= tolerance || s->granted++);
}

/* Newton from z, with a line search on |F|^2 / 2. A step of which the line search takes next to nothing
   is damped, the more the less it helps. Returns 1 with z solved to the tolerance, or 0. It aims at
   rounding, and is content with the tolerance, or with a rounding floor above it, only where another
   iteration does not halve the residual (friction that the floor grants gets one more, to go from sticking to
   slipping): what one step misses is missed again by the warm start of the next, and adds up. Well below it an
   iteration that makes things worse is not taken. A start that is well below the tolerance is left as it is if
   `warm` says so, one in which nothing moves (warm = 2, so nothing adds up) if it is below. */
static int ecp_i_newton(const ecp_i_problem *p, int warm, ecp_real tolerance, int limit,
                        ecp_real relax, ecp_real *z, ecp_i_effort *effort)
{
    ecp_i_search s;
    ecp_i_size was;
    const ecp_i_size *now = &effort->size;
    ecp_real t;
    int k, i, most = limit;
    s.aim = ecp_i_aim(tolerance);
    s.content = ecp_i_content(tolerance);
    ecp_i_evaluate(p, z, relax, effort);
    if (ecp_i_at_rounding(now, &s) || ecp_i_start_will_do(now, warm, tolerance, &s)) return 1;
    if (warm && ecp_i_better_start(p, tolerance, z, effort) &&
        ecp_i_start_will_do(now, warm, tolerance, &s))
        return 1;
    ecp_i_begin_search(p, &s);
    for (k = 0; k < most; k++) {
        if (ecp_i_spent(effort)) {
            effort->most = -1;
            break;
        }
        if (!p->step(p->self, z, p->F, s.fine, s.compliance, p->dz)) break;
        effort->iterations++;
        was = *now;
        t = ecp_i_line_search(p, z, tolerance, relax, &s, effort);
        if (!(t > 0)) {
            /* back to the last point; it may be one that will do */
            ecp_i_evaluate(p, z, relax, effort);
            if (was.error <= tolerance || s.compliance >= ECP_I_MOST_COMPLIANCE)
                return was.error <= tolerance;
            if (!(s.compliance > 0) || was.error >= ECP_I_STALLED || s.strides++ >= ECP_I_STRIDES) {
                most = ecp_i_damp(p, &s, limit);
                continue;
            }
        }
        if (now->error > tolerance && s.compliance > 0 && 2 * now->error > was.error &&
            was.error < ECP_I_STALLED) {
            ecp_i_take_stride(p, z, relax, &s, effort);
            was.error = 2 * now->error; /* it is not asked to halve the residual */
        } else {
            ecp_i_adapt_compliance(&was, now, t, tolerance, &s);
        }
        ecp_i_copy(p->n, p->trial, z);
        if (t >= 1 && s.compliance == 0) ecp_i_repeat(p, was.rest, relax, z, &s, effort);
        if (ecp_i_at_rounding(now, &s) || ecp_i_is_enough(&was, now, tolerance, &s)) return 1;
        /* constraints are told apart no more finely than they hold yet: forces would fight over the
           difference */
        if (2 * now->error > was.error) {
            s.fine = ecp_i_max(ecp_i_min(s.fine / 10, 100 * now->error), now->error / 10);
        }
        s.merits[k % ECP_I_MEMORY] = s.merit;
        if (ECP_I_GIVES_UP && ecp_i_circles(&s)) {
            if (!ecp_i_is_patient(p, relax) && s.compliance >= ECP_I_STALE_COMPLIANCE) break;
            /* the next step compares itself with this one alone */
            for (i = 0; ecp_i_is_large(p) && i < ECP_I_MEMORY; i++) s.merits[i] = s.merit;
        }
    }
    return now->error <= tolerance;
}

/* How the solution of the relaxed problem is followed: where relaxation begins; what divides it from one
   search to the next; the residual that a search aims at, in relaxations; and, in haste, the limit of
   its iterations and what is left of relaxation from one trial of the true problem to the next. */
#define ECP_I_FIRST_RELAX ECP_R(1)
#define ECP_I_RELAX_DIVISOR ECP_R(4)
#define ECP_I_RELAX_PART ECP_R(0.01)
#define ECP_I_HASTY_FIRST_RELAX ECP_R(0.1)
#define ECP_I_HASTY_DIVISOR ECP_R(10)
#define ECP_I_HASTY_PART ECP_R(0.3)
#define ECP_I_HASTY_LIMIT 15
#define ECP_I_HASTY_FIRST_TRIAL ECP_R(3e-5)
#define ECP_I_HASTY_TRIALS ECP_R(1e-3)

/* Follows the solution of the relaxed problem, in which complementarity is smoothed, faces are curved and
   contacts give way, until that is far below the tolerance, then solves the true one. */
static int ecp_i_continue(const ecp_i_problem *p, ecp_real tolerance, int limit, ecp_real *z,
                          ecp_i_effort *effort)
{
    ecp_real relax = ECP_I_FIRST_RELAX;
    effort->fallbacks |= ECP_FALLBACK_CONTINUATION;
    for (; relax > tolerance / 100 && !ecp_i_spent(effort); relax /= ECP_I_RELAX_DIVISOR) {
        ecp_i_newton(p, 0, ecp_i_max(relax * ECP_I_RELAX_PART, tolerance), limit, relax, z, effort);
        if (!ecp_i_all_finite(p->n, z)) return 0;
    }
    return ecp_i_newton(p, 0, tolerance, limit, 0, z, effort);
}

/* The same with longer strides, less close to the path; tries the true problem whenever relaxation has
   come down a thousandfold: most often that is solved from far above the tolerance. */
static int ecp_i_continue_in_haste(const ecp_i_problem *p, ecp_real tolerance, ecp_real *z,
                                   ecp_i_effort *effort)
{
    ecp_real relax = ECP_I_HASTY_FIRST_RELAX, trial = ECP_I_HASTY_FIRST_TRIAL;
    effort->fallbacks |= ECP_FALLBACK_CONTINUATION;
    for (; relax > tolerance / 100 && !ecp_i_spent(effort); relax /= ECP_I_HASTY_DIVISOR) {
        ecp_i_newton(p, 0, ecp_i_max(relax * ECP_I_HASTY_PART, tolerance), ECP_I_HASTY_LIMIT, relax,
                     z, effort);
        if (!ecp_i_all_finite(p->n, z)) return 0;
        if (relax > trial) continue;
        trial *= ECP_I_HASTY_TRIALS;
        ecp_i_copy(p->n, z, p->kept);
        if (ecp_i_newton(p, 0, tolerance, ECP_I_HASTY_LIMIT, 0, z, effort)) return 1;
        ecp_i_copy(p->n, p->kept, z);
    }
    return 0;
}

#define ECP_I_START_AT_REST 4

/* Lets the load grow from nothing, in steps that double where Newton follows and shrink where it does
   not. */
static int ecp_i_ramp(const ecp_i_problem *p, ecp_real tolerance, int limit, ecp_real *z,
                      ecp_i_effort *effort)
{
    ecp_real share = 0, step = ECP_R(0.125);
    int k;
    effort->fallbacks |= ECP_FALLBACK_LOAD;
    p->start(p->self, ECP_I_START_AT_REST, z);
    ecp_i_copy(p->n, z, p->kept);
    for (k = 0; k < 40 && share < 1 && step > ECP_R(1e-3) && !ecp_i_spent(effort); k++) {
        ecp_real next = ecp_i_min(1, share + step);
        p->load(p->self, next);
        if (ecp_i_newton(p, 0, tolerance, limit, 0, z, effort)) {
            ecp_i_copy(p->n, z, p->kept);
            share = next;
            step *= 2;
        } else {
            ecp_i_copy(p->n, p->kept, z);
            step /= 4;
        }
    }
    p->load(p->self, 1);
    return share >= 1;
}

/* Newton from a start; if that is the warm one, by the working set (first of all, if that has solved the last step),
   and of many unknowns from the second geometric start, and continuation in haste; then Newton again from where it has
   stalled, if that can be bettered. */
static int ecp_i_attempt(const ecp_i_problem *p, int warm, const ecp_options *o, ecp_real *z,
                         ecp_i_effort *effort)
{
    int gathers = ECP_I_PAIRS && warm && p->gather && ecp_i_may(o, ECP_FALLBACK_WORKING_SET);
    if (gathers && p->gathered) {
        if (p->gather(p->self, p, o, z, effort)) return 1;
        if (ecp_i_spent(effort)) return 0;
        gathers = 0;
        warm = p->start(p->self, 0, z);
    }
    if (ecp_i_newton(p, warm, o->tolerance, o->max_iterations, 0, z, effort)) return 1;
    if (ecp_i_spent(effort)) return 0;
    if (gathers) {
        ecp_i_copy(p->n, z, p->stalled);
        if (p->gather(p->self, p, o, z, effort)) return 1;
        if (ecp_i_spent(effort)) return 0;
        ecp_i_copy(p->n, p->stalled, z);
        ecp_i_evaluate(p, z, 0, effort);
    }
    if (warm && ecp_i_is_large(p) && ecp_i_may(o, ECP_FALLBACK_CONTINUATION) && p->stalled) {
        ecp_i_copy(p->n, z, p->stalled);
        if (ecp_i_may(o, ECP_FALLBACK_GEOMETRIC)) {
            effort->fallbacks |= ECP_FALLBACK_GEOMETRIC;
            p->start(p->self, 2, z);
            if (ecp_i_newton(p, 0, o->tolerance, o->max_iterations, 0, z, effort)) return 1;
        }
        p->start(p->self, 0, z);
        if (ecp_i_continue_in_haste(p, o->tolerance, z, effort)) return 1;
        ecp_i_copy(p->n, p->stalled, z);
        ecp_i_evaluate(p, z, 0, effort);
    }
    if (!ecp_i_may(o, ECP_FALLBACK_GEOMETRIC) || !p->repair) return 0;
    effort->fallbacks |= ECP_FALLBACK_GEOMETRIC;
    p->repair(p->self, z);
    return ecp_i_newton(p, 0, o->tolerance, o->max_iterations, 0, z, effort);
}

/* Is that a solution to take? One in which nothing moves is. */
static int ecp_i_takes(const ecp_i_problem *p, int solved, int still)
{
    return solved && (!ECP_I_PAIRS || still || !p->valid || p->valid(p->self));
}

/* The chain of attempts: Newton from the warm and the two geometric starts; the load grown from rest; from the second
   geometric start continuation in the relaxation, with care; then the other starts, by Newton (fully relaxed all
   starts lead to one solution). */
static int ecp_i_solve(const ecp_i_problem *p, const ecp_options *o, ecp_real *z,
                       ecp_i_effort *effort)
{
    int k, warm, solved, limit = o->max_iterations;
    for (k = 0;; k++) {
        int kind = k > 2 ? ECP_FALLBACK_MULTISTART : k > 0 ? ECP_FALLBACK_GEOMETRIC : 0;
        if (k > 0 && ecp_i_spent(effort)) break; /* a start takes as long as some iterations */
        if (k > 2 && !ecp_i_may(o, kind)) break;
        if (k == 0 || ecp_i_may(o, kind)) {
            warm = p->start(p->self, k, z);
            if (warm == 0) break;
            effort->fallbacks |= kind;
            solved = ecp_i_attempt(p, k == 0 ? warm : 0, o, z, effort);
            if (ecp_i_takes(p, solved, k == 0 && warm > 1 && effort->iterations == 0)) return 1;
        }
        if (k == 2 && ecp_i_in_haste(p)) break;
        if (k == 2 && ecp_i_may(o, ECP_FALLBACK_LOAD) && p->load) {
            solved = ecp_i_ramp(p, o->tolerance, limit, z, effort);
            if (ecp_i_takes(p, solved, 0)) return 1;
        }
        if (k == 2 && ecp_i_may(o, ECP_FALLBACK_CONTINUATION)) {
            p->start(p->self, k, z);
            solved = ecp_i_continue(p, o->tolerance, limit, z, effort);
            if (ecp_i_takes(p, solved, 0)) return 1;
        }
    }
    return 0;
}

ECP_DEF ecp_options ecp_options_default(void)
{
    ecp_options o;
    o.rule = ECP_I_CENTRING ? ECP_CENTRED : ECP_NEAREST;
#ifdef ECPSIM_FLOAT
    o.tolerance = ECP_R(1e-5);
#else
    o.tolerance = ECP_R(1e-12);
#endif
    o.max_iterations = 40;
    o.max_total_iterations = 0;
    o.fallbacks = ECPSIM_FALLBACKS;
    o.sleep = 0;
    o.dump = NULL;
    o.dump_write = NULL;
    o.dump_user = NULL;
    return o;
}

static ecp_status ecp_i_check_options(const ecp_options *o)
{
    if (!ecp_i_finite(o->tolerance)) return ECP_NOT_FINITE;
    if (!(o->tolerance > 0) || o->max_iterations < 1 || o->max_total_iterations < 0 ||
        (o->fallbacks & ~(ECPSIM_FALLBACKS))) {
        return ECP_BAD_OPTION;
    }
    if (o->dump && !o->dump_write) return ECP_BAD_POINTER;
    if (o->sleep != 0 && o->sleep != ECP_I_SLEEP) return ECP_BAD_OPTION;
    return (ECP_I_CENTRING && o->rule == ECP_CENTRED) || o->rule == ECP_NEAREST ? ECP_OK
                                                                                : ECP_BAD_OPTION;
}

/* >>mcp: the general problem, dense */

typedef struct ecp_i_mcp {
    const ecp_mcp *problem;
    ecp_real *value, *J, *rhs, *work, *z0, *unit;
    int *ints;
    ecp_real tau;
} ecp_i_mcp;

/* a real whose square is still a number */
#ifdef ECPSIM_FLOAT
#define ECP_I_SQUARABLE ECP_R(1e18)
#else
#define ECP_I_SQUARABLE ECP_R(1e150)
#endif

/* ecp_i_fb of numbers of any size (it is homogeneous), and without cancellation where one is negative and the other
   large as well: in a step's units the former is not needed, and the latter in Newton steps alone. */
static ecp_real ecp_i_mcp_fb(ecp_real a, ecp_real b, ecp_real tau, ecp_real *da, ecp_real *db)
{
    ecp_real unit = ecp_i_max(ecp_i_abs(a), ecp_i_abs(b)), value, least, most;
    if (!(unit > ECP_I_SQUARABLE)) unit = 1;
    a /= unit;
    b /= unit;
    tau /= unit;
    value = ecp_i_fb(a, b, tau, da, db);
    least = ecp_i_min(a, b);
    most = ecp_i_max(a, b);
    if (least < 0 && most > 0) value = ecp_i_fb_mixed(least, most, tau);
    return unit * value;
}

static void ecp_i_mcp_residual(void *self, const ecp_real *z, ecp_real tau, ecp_real *F,
                               ecp_i_size *total)
{
    ecp_i_mcp *s = (ecp_i_mcp *)self;
    ecp_real worst = 0, da, db;
    int i, n = s->problem->n, size = n + s->problem->m;
    s->problem->function(s->problem->user, z, s->value);
    s->tau = tau;
    for (i = 0; i < size; i++) {
        F[i] = i < n ? s->value[i] : ecp_i_mcp_fb(z[i], s->value[i], tau, &da, &db);
        ecp_i_worst(&worst, ecp_i_abs(F[i]));
    }
    total->largest = total->error = total->rest = worst;
    total->friction = 0;
}

/* Rows da e_i + db grad F_i; the least step where they are dependent, which is judged, and least, in units of the
   unknowns that make the columns alike: no unknown is lost for the size of its own. */
static int ecp_i_mcp_step(void *self, const ecp_real *z, const ecp_real *F, ecp_real fine,
                          ecp_real compliance, ecp_real *dz)
{
    ecp_i_mcp *s = (ecp_i_mcp *)self;
    ecp_real da, db;
    int i, j, n = s->problem->n, size = n + s->problem->m;
    (void)fine;
    s->problem->jacobian(s->problem->user, z, s->J);
    for (i = 0; i < size; i++) {
        s->rhs[i] = -F[i];
        s->J[size * i + i] += compliance;
        if (i < n) continue;
        ecp_i_mcp_fb(z[i], s->value[i], s->tau, &da, &db);
        for (j = 0; j < size; j++) s->J[size * i + j] *= db;
        s->J[size * i + i] += da;
    }
    if (!ecp_i_all_finite(size * size, s->J)) return 0;
    for (j = 0; j < size; j++) {
        s->unit[j] = 0;
        for (i = 0; i < size; i++) ecp_i_raise(s->unit + j, ecp_i_abs(s->J[size * i + j]));
        if (!(s->unit[j] > 0)) s->unit[j] = 1;
        for (i = 0; i < size; i++) s->J[size * i + j] /= s->unit[j];
    }
    ecp_least_squares(size, size, s->J, size, s->rhs, dz, s->work, s->ints, 64 * ECP_I_EPSILON);
    for (j = 0; j < size; j++) dz[j] /= s->unit[j];
    return ecp_i_all_finite(size, dz);
}

/* the caller's start, for continuation as well; from the third on starts disturbed by a fixed sequence (a linear
   congruence), at most by a half of the start's size, and by twice as much each time */
static int ecp_i_mcp_start(void *self, int k, ecp_real *z)
{
    ecp_i_mcp *s = (ecp_i_mcp *)self;
    int i, size = s->problem->n + s->problem->m;
    unsigned seed = 12345u + 7919u * (unsigned)k;
    ecp_real reach = ECP_R(0.5);
    if (k > 8) return 0;
    for (i = 3; i < k; i++) reach *= 2;
    for (i = 0; i < size; i++) {
        seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
        z[i] = s->z0[i];
        if (k < 3) continue;
        z[i] +=
            reach * (1 + ecp_i_abs(z[i])) * ((ecp_real)(seed >> 16) / ECP_R(16384.0) - ECP_R(1.0));
        if (i >= s->problem->n) z[i] = ecp_i_max(z[i], 0);
    }
    return 1;
}

static void ecp_i_carve_mcp(ecp_i_arena *arena, int size, ecp_i_mcp *s, ecp_i_problem *p,
                            ecp_real **z)
{
    s->value = ecp_i_take_reals(arena, size, 1);
    s->J = ecp_i_take_reals(arena, size, size);
    s->rhs = ecp_i_take_reals(arena, size, 1);
    s->work = ecp_i_take_reals(arena, size, size + 3);
    s->z0 = ecp_i_take_reals(arena, size, 1);
    s->unit = ecp_i_take_reals(arena, size, 1);
    s->ints = ecp_i_take_ints(arena, 2 * size);
    p->F = ecp_i_take_reals(arena, size, 1);
    p->dz = ecp_i_take_reals(arena, size, 1);
    p->trial = ecp_i_take_reals(arena, size, 1);
    p->drift = ecp_i_take_reals(arena, size, 1);
    *z = ecp_i_take_reals(arena, size, 1);
}

ECP_DEF size_t ecp_mcp_memsize(int n, int m)
{
    ecp_i_arena arena = ecp_i_arena_over(NULL, 0);
    ecp_i_mcp s;
    ecp_i_problem p;
    ecp_real *z;
    if (n < 0 || m < 0 || n > 10000 || m > 10000 || n + m < 1) return 0;
    ecp_i_carve_mcp(&arena, n + m, &s, &p, &z);
    return arena.overflow ? 0 : arena.used;
}

ECP_DEF ecp_status ecp_mcp_solve(const ecp_mcp *problem, const ecp_options *options, ecp_real *z,
                                 void *mem, size_t bytes, ecp_mcp_report *report)
{
    ecp_options o = ecp_options_default();
    ecp_i_arena arena;
    ecp_i_effort effort;
    ecp_i_mcp s;
    ecp_i_problem p;
    ecp_real *work;
    ecp_status status;
    size_t need;
    int size, solved;
    if (!problem || !z || !mem || !problem->function || !problem->jacobian) return ECP_BAD_POINTER;
    need = ecp_mcp_memsize(problem->n, problem->m);
    if (need == 0) return ECP_BAD_OPTION;
    if (((size_t)mem & 7) != 0) return ECP_MEMORY_ALIGN;
    if (bytes < need) return ECP_MEMORY_SMALL;
    if (options) o = *options;
    status = ecp_i_check_options(&o);
    if (status != ECP_OK) return status;
    /* there is no geometry */
    o.fallbacks &= ~ECP_FALLBACK_GEOMETRIC;
    size = problem->n + problem->m;
    if (!ecp_i_all_finite(size, z)) return ECP_NOT_FINITE;
    arena = ecp_i_arena_over(mem, bytes);
    ecp_i_carve_mcp(&arena, size, &s, &p, &work);
    s.problem = problem;
    p.self = &s;
    p.n = size;
    p.residual = ecp_i_mcp_residual;
    p.step = ecp_i_mcp_step;
    p.again = NULL;
    p.turn = NULL;
    p.event = NULL;
    p.start = ecp_i_mcp_start;
    p.repair = NULL;
    if (ECP_I_PAIRS) p.gather = NULL;
    p.valid = NULL;
    p.load = NULL;
    p.kept = p.stalled = NULL;
    p.velocities = p.large = p.hurries = p.gathered = p.calm = 0;
    p.patient = !ecp_i_may(&o, ECP_I_RESTARTS);
    ecp_i_copy(size, z, s.z0);
    effort = ecp_i_effort_after(&o, 0);
    solved = ecp_i_solve(&p, &o, work, &effort);
    if (solved) ecp_i_copy(size, work, z);
    if (report) {
        report->iterations = effort.iterations;
        report->evaluations = effort.evaluations;
        report->fallbacks = effort.fallbacks;
        ecp_i_mcp_residual(&s, work, 0, p.F, &effort.size);
        report->natural_residual = effort.size.largest;
        report->merit = ecp_i_merit(size, p.F);
    }
    return solved ? ECP_OK : ECP_NOT_SOLVED;
}

/* >>distance ==============================================================================
   Where two convex primitives are nearest, by their support functions alone (Gilbert, Johnson,
   Keerthi): a rough answer that starts Newton on a patch without a history, and a lower bound that
   leaves pairs out. */

typedef struct ecp_i_posed {
    const ecp_shape *shape;
    ecp_real Q[9], x[3]; /* world pose of the primitive, up to one origin for all */
    ecp_real way[3];     /* with all that it sweeps on this way; zero but in ecp_i_passes */
} ecp_i_posed;

/* the farthest point of a posed primitive along the world direction n (any length) */
static void ecp_i_farthest(const ecp_i_posed *p, const ecp_real n[3], ecp_real flat,
                           ecp_real out[3])
{
    ecp_real unit[3], local[3], at[3];
    ecp_i_copy3(n, unit);
    ecp_i_normalise(unit);
    ecp_i_mul_t(p->Q, unit, local);
    p->shape->cls->support(p->shape, local, flat, at);
    ecp_i_mul(p->Q, at, out);
    ecp_i_add(out, p->x, out);
    if (ECP_I_PAIRS && ecp_i_dot(n, p->way) > 0) ecp_i_add(out, p->way, out);
}

static void ecp_i_posed_centre(const ecp_i_posed *p, ecp_real out[3])
{
    ecp_i_mul(p->Q, p->shape->centre, out);
    ecp_i_add(out, p->x, out);
}

/* how far A and B are apart along n (from A to B): the certificate -(h_A(n) + h_B(-n)) */
static ecp_real ecp_i_separation(const ecp_i_posed *A, const ecp_i_posed *B, const ecp_real n[3])
{
    ecp_real pa[3], pb[3], back[3], gap[3];
    ecp_i_scale(-1, n, back);
    ecp_i_farthest(A, n, 0, pa);
    ecp_i_farthest(B, back, 0, pb);
    ecp_i_sub(pb, pa, gap);
    return ecp_i_dot(n, gap);
}

/* the point of the hull of w[0..count) nearest to the origin, as weights; tries every face of the
   simplex, so it does not depend on luck with degenerate ones */
static void ecp_i_nearest(int count, ecp_real w[4][3], ecp_real weight[4])
{
    ecp_real best = -1;
    int set, i, j, k;
    for (set = 1; set < 1 << count; set++) {
        ecp_real E[3][3], G[9], l[3], x[3], first = 1, size;
        int member[4], m = 0, inside;
        for (i = 0; i < count; i++) {
            if (set >> i & 1) member[m++] = i;
        }
        for (i = 0; i + 1 < m; i++) ecp_i_sub(w[member[i + 1]], w[member[0]], E[i]);
        for (i = 0; i + 1 < m; i++) {
            for (j = 0; j + 1 < m; j++) G[3 * i + j] = ecp_i_dot(E[i], E[j]);
            l[i] = -ecp_i_dot(E[i], w[member[0]]);
        }
        if (ecp_chol_factor(m - 1, G, 3)) continue;
        ecp_chol_solve(m - 1, G, 3, l);
        for (i = 0, inside = 1; i + 1 < m; i++) {
            first -= l[i];
            inside &= l[i] >= 0;
        }
        if (!inside || !(first >= 0)) continue;
        ecp_i_copy3(w[member[0]], x);
        for (i = 0; i + 1 < m; i++) ecp_i_axpy(x, l[i], E[i], x);
        size = ecp_i_dot(x, x);
        if (best >= 0 && !(size < best)) continue;
        best = size;
        for (k = 0; k < 4; k++) weight[k] = 0;
        weight[member[0]] = first;
        for (i = 0; i + 1 < m; i++) weight[member[i + 1]] = l[i];
    }
}

/* The distance of A and B to a relative accuracy of 1e-4, their nearest points, and the unit n from
   A to B; 0 if they touch or overlap, and then only the points mean something. */
static ecp_real ecp_i_distance(const ecp_i_posed *A, const ecp_i_posed *B, ecp_real at_a[3],
                               ecp_real at_b[3], ecp_real n[3])
{
    ecp_real pa[4][3], pb[4][3], w[4][3], weight[4] = {1, 0, 0, 0}, v[3], back[3], size = 0;
    ecp_real tiny = ecp_i_sqrt(ECP_I_EPSILON) * (A->shape->radius + B->shape->radius);
    int count = 0, k, i, j;
    ecp_i_posed_centre(A, at_a);
    ecp_i_posed_centre(B, at_b);
    ecp_i_sub(at_b, at_a, v);
    if (!(ecp_i_norm(v) > tiny)) ecp_i_set3(0, 0, 1, v);
    for (k = 0; k < 40; k++) {
        ecp_i_scale(-1, v, back);
        ecp_i_farthest(A, v, 0, pa[count]);
        ecp_i_farthest(B, back, 0, pb[count]);
        ecp_i_sub(pb[count], pa[count], w[count]);
        if (k > 0 && size * size - ecp_i_dot(v, w[count]) <= ECP_R(1e-4) * size * size) break;
        count++;
        ecp_i_nearest(count, w, weight);
        for (i = 0, j = 0; i < count; i++) {
            if (!(weight[i] > 0)) continue;
            ecp_i_copy3(w[i], w[j]);
            ecp_i_copy3(pa[i], pa[j]);
            ecp_i_copy3(pb[i], pb[j]);
            weight[j++] = weight[i];
        }
        count = j;
        ecp_i_set3(0, 0, 0, v);
        for (i = 0; i < count; i++) ecp_i_axpy(v, weight[i], w[i], v);
        size = ecp_i_norm(v);
        if (count == 4 || size <= tiny) {
            size = 0;
            break;
        }
    }
    ecp_i_set3(0, 0, 0, at_a);
    ecp_i_set3(0, 0, 0, at_b);
    for (i = 0; i < count; i++) {
        ecp_i_axpy(at_a, weight[i], pa[i], at_a);
        ecp_i_axpy(at_b, weight[i], pb[i], at_b);
    }
    if (size > 0) ecp_i_scale(1 / size, v, n);
    return size;
}

/* >>start: values for a patch's unknowns without a history */

/* Multipliers l >= 0 with sum l_i g_i nearest to n, over the constraints that are active at the
   point (f_i no more than `reach` below the largest): coordinate descent, exact for orthogonal
   gradients, enough for a start. */
static void ecp_i_cone_multipliers(int count, const ecp_real *f, const ecp_real *g,
                                   const ecp_real n[3], ecp_real reach, ecp_real *l)
{
    ecp_real rest[3], best = f[0];
    int i, sweep;
    ecp_i_copy3(n, rest);
    for (i = 0; i < count; i++) {
        l[i] = 0;
        best = ecp_i_max(best, f[i]);
    }
    for (sweep = 0; sweep < 30; sweep++) {
        for (i = 0; i < count; i++) {
            const ecp_real *gi = g + 3 * i;
            ecp_real size = ecp_i_dot(gi, gi), next;
            if (f[i] < best - reach || !(size > 0)) continue;
            next = ecp_i_max(0, l[i] + ecp_i_dot(gi, rest) / size);
            ecp_i_axpy(rest, l[i] - next, gi, rest);
            l[i] = next;
        }
    }
}

/* where a primitive is whose rotation p->Q is known */
static void ecp_i_pose_turned(const ecp_i_pair *c, int side, int at_end, ecp_i_posed *p)
{
    const ecp_i_part *part = side ? c->b : c->a;
    const ecp_i_motion *m = side ? c->mb : c->ma;
    p->shape = &part->shape;
    if (ECP_I_PAIRS) ecp_i_set3(0, 0, 0, p->way);
    ecp_i_mul(at_end ? m->R : m->R0, part->position, p->x);
    if (at_end) ecp_i_add(p->x, m->dx, p->x);
    if (side) ecp_i_sub(p->x, c->offset, p->x);
}

/* where a primitive is: at the end of the trial motion, or at the beginning of the step; positions
   are counted from A's centre of mass at the beginning of the step */
static void ecp_i_pose(const ecp_i_pair *c, int side, int at_end, ecp_i_posed *p)
{
    const ecp_i_part *part = side ? c->b : c->a;
    const ecp_i_motion *m = side ? c->mb : c->ma;
    ecp_i_matmul(at_end ? m->R : m->R0, part->rotation, p->Q);
    ecp_i_pose_turned(c, side, at_end, p);
}

static void ecp_i_poses(const ecp_i_pair *c, int at_end, ecp_i_posed *A, ecp_i_posed *B)
{
    ecp_i_pose(c, 0, at_end, A);
    ecp_i_pose(c, 1, at_end, B);
}

/* the unit normal from A into the half-space B, and the gap along it */
static ecp_real ecp_i_plane_gap(const ecp_i_posed *A, const ecp_i_posed *B, ecp_real flat,
                                ecp_real n[3], ecp_real at[3])
{
    ecp_real N[3], rel[3];
    ecp_i_mul(B->Q, B->shape->size, N);
    ecp_i_scale(-1, N, n);
    ecp_i_farthest(A, n, flat, at);
    ecp_i_sub(at, B->x, rel);
    return ecp_i_dot(N, rel) - B->shape->size[3];
}

/* Nearest points and normal of two primitives that overlap (points that touch have no direction
   between them): B is moved along the line of the centres until they are apart. */
static void ecp_i_move_apart(const ecp_i_posed *A, ecp_i_posed *B, ecp_real at_a[3],
                             ecp_real at_b[3], ecp_real n[3])
{
    ecp_real apart[3], x[3], most = 4 * (A->shape->radius + B->shape->radius);
    ecp_real shift = ECP_R(1e-3) * ecp_i_min(A->shape->radius, B->shape->radius);
    ecp_i_posed_centre(A, x);
    ecp_i_posed_centre(B, apart);
    ecp_i_sub(apart, x, apart);
    if (!ecp_i_normalise(apart)) ecp_i_set3(0, 0, 1, apart);
    ecp_i_copy3(B->x, x);
    /* less than rounding moves nothing, and nothing may have no end */
    for (shift = ecp_i_max(shift, ECP_I_EPSILON * most);; shift *= ECP_R(1.5)) {
        ecp_i_axpy(x, shift, apart, B->x);
        if (ecp_i_distance(A, B, at_a, at_b, n) > 0) return;
        if (!(shift < most)) break;
    }
    ecp_i_copy3(apart, n);
}

/* How deep two that overlap are in each other along n, the normal when they have been moved apart. By the nearest
   points: the far end of a wall says as overlap what its normal is off. */
static ecp_real ecp_i_overlap(const ecp_i_posed *A, const ecp_i_posed *B, ecp_real n[3])
{
    ecp_i_posed apart = *B;
    ecp_real at_a[3], at_b[3], way[3];
    ecp_i_move_apart(A, &apart, at_a, at_b, n);
    ecp_i_sub(B->x, apart.x, way);
    ecp_i_add(way, at_b, way);
    ecp_i_sub(way, at_a, way);
    return -ecp_i_dot(n, way);
}

/* what counts as apart, or as the rounding of it */
static ecp_real ecp_i_slack(const ecp_i_pair *c)
{
    return ecp_i_sqrt(ECP_I_EPSILON) * (c->a->shape.radius + c->b->shape.radius);
}

/* the way of B as seen from A, from their poses where the step begins to the end of the trial motion */
static void ecp_i_moved(const ecp_i_pair *c, const ecp_i_posed *A, const ecp_i_posed *B,
                        ecp_real way[3])
{
    ecp_i_posed end;
    ecp_i_pose(c, 0, 1, &end);
    ecp_i_sub(A->x, end.x, way);
    ecp_i_pose(c, 1, 1, &end);
    ecp_i_add(way, end.x, way);
    ecp_i_sub(way, B->x, way);
}

/* Have the two gone through each other? Then they are apart at the end of the trial motion, along n, but the normal
   has turned round, as the one that turns less sees it, and B was in A on the way (as poses are where the step
   begins). What overlapped before may leave where it likes. Returns how deep in each other along n they were where the
   step began, so to speak, or 0. */
static ecp_real ecp_i_passes(const ecp_i_pair *c, const ecp_real n[3])
{
    ecp_i_posed A, B;
    ecp_real at_a[3], at_b[3], before[3], local[3], turned[3], depth;
    const ecp_i_motion *m = ecp_i_norm(c->ma->v + 3) > ecp_i_norm(c->mb->v + 3) ? c->mb : c->ma;
    ecp_i_poses(c, 0, &A, &B);
    depth = -ecp_i_separation(&A, &B, n);
    if (depth <= ecp_i_slack(c)) return 0;
    if (!(ecp_i_distance(&A, &B, at_a, at_b, before) > 0) &&
        ecp_i_overlap(&A, &B, before) > ecp_i_slack(c))
        return 0;
    ecp_i_mul_t(m->R0, before, local);
    ecp_i_mul(m->R, local, turned);
    if (ecp_i_dot(turned, n) >= -ECP_R(0.5))
        return 0; /* by less than 120 degrees: round a corner */
    ecp_i_moved(c, &A, &B, B.way);
    /* (what is off the way by less than its rounding is on it) */
    return ecp_i_distance(&A, &B, at_a, at_b, before) > 4 * ECP_I_EPSILON * ecp_i_norm(B.way)
               ? ECP_R(0)
               : depth;
}

/* How far apart A and B would be along n after a step in which both move on as they do at its beginning, where
   they are posed. */
static ecp_real ecp_i_coasting(const ecp_i_pair *c, const ecp_i_posed *A, const ecp_i_posed *B,
                               ecp_real h, const ecp_real n[3])
{
    const ecp_real *va = c->ma->body->v, *vb = c->mb->body->v;
    ecp_real pa[3], pb[3], back[3], v[3];
    ecp_i_scale(-1, n, back);
    ecp_i_farthest(A, n, 0, pa);
    ecp_i_farthest(B, back, 0, pb);
    ecp_i_sub(vb, va, v);
    ecp_i_sub(pb, pa, back);
    ecp_i_axpy(back, h, v, back);
    ecp_i_cross(va + 3, pa, v);
    ecp_i_axpy(back, -h, v, back);
    ecp_i_add(pb, c->offset, pb);
    ecp_i_cross(vb + 3, pb, v);
    ecp_i_axpy(back, h, v, back);
    return ecp_i_dot(n, back);
}

/* how far two slide on each other in a step, in their radii, so that it matters to which of them a point belongs */
#define ECP_I_LONG_SLIDE ECP_R(0.1)

/* Two that overlap at the end of the predicted motion, or have passed each other, leave each other along n where
   they were apart when the step began, unless a normal of one of their faces parted them as well and is the shorter
   way out, by half, of what their velocities do: a box that slides over a seam between others is held by the tops
   of them all, and not by the side of the next. Then A, B, the nearest points and n are those of the end, with B
   moved out that way. */
static void ecp_i_shorter_way(const ecp_i_pair *c, ecp_real h, ecp_i_posed *A, ecp_i_posed *B,
                              ecp_real at_a[3], ecp_real at_b[3], ecp_real n[3])
{
    ecp_i_posed A0, B0, A1, B1;
    ecp_real local[3], before[3], after[3], out[3], best, way;
    int side, i;
    ecp_i_poses(c, 0, &A0, &B0);
    ecp_i_poses(c, 1, &A1, &B1);
    best = ecp_i_coasting(c, &A0, &B0, h, n);
    ecp_i_copy3(n, out);
    for (side = 0; side < 2 && best < -ecp_i_slack(c); side++) {
        const ecp_i_posed *first = side ? &B0 : &A0, *last = side ? &B1 : &A1;
        ecp_real *f = side ? c->on_b->fb : c->fa, *g = side ? c->on_b->gb : c->ga;
        ecp_i_sub(side ? at_b : at_a, (side ? B : A)->x, before);
        ecp_i_mul_t(first->Q, before, local);
        first->shape->cls->eval(first->shape, local, f, g);
        for (i = 0; i < (side ? c->nm : c->nl); i++) {
            if (!ecp_i_normalise(g + 3 * i)) continue;
            if (side) ecp_i_scale(-1, g + 3 * i, g + 3 * i);
            ecp_i_mul(first->Q, g + 3 * i, before);
            if (ecp_i_separation(&A0, &B0, before) < -ecp_i_slack(c)) continue;
            way = ecp_i_coasting(c, &A0, &B0, h, before);
            if (!(2 * way > best) || !(way > best)) continue;
            best = way;
            ecp_i_mul(last->Q, g + 3 * i, out);
        }
    }
    if (ecp_i_equal(out, n)) {
        /* the points of the beginning will do where the two slide by little */
        ecp_i_moved(c, &A0, &B0, before);
        ecp_i_axpy(before, -ecp_i_dot(before, n), n, before);
        if (ecp_i_norm(before) <= ECP_I_LONG_SLIDE * ecp_i_min(A1.shape->radius, B1.shape->radius))
            return;
    }
    way = ecp_i_max(-ecp_i_separation(&A1, &B1, out), 0);
    way += ECP_R(1e-3) * ecp_i_min(A1.shape->radius, B1.shape->radius) + 2 * ecp_i_slack(c);
    ecp_i_axpy(B1.x, way, out, B1.x);
    if (!(ecp_i_distance(&A1, &B1, before, after, out) > 0)) return;
    *A = A1;
    *B = B1;
    ecp_i_copy3(before, at_a);
    ecp_i_copy3(after, at_b);
    ecp_i_copy3(out, n);
}

/* Nearest points, in the frames of the primitives, and normal of a pair, wherever it is: apart at the
   end of the predicted motion (if from_end), unless they have passed each other there, or else at the
   beginning of the step, or else moved apart. */
static void ecp_i_pair_nearest(const ecp_i_pair *c, int from_end, ecp_real h, ecp_real at_a[3],
                               ecp_real at_b[3], ecp_real n[3])
{
    ecp_i_posed A, B;
    ecp_real x[3];
    int at_end;
    for (at_end = from_end; at_end >= 0; at_end--) {
        ecp_i_poses(c, at_end, &A, &B);
        if (ecp_i_distance(&A, &B, at_a, at_b, n) > 0 && !(at_end && ecp_i_passes(c, n) > 0)) break;
    }
    if (at_end < 0) ecp_i_move_apart(&A, &B, at_a, at_b, n);
    if (from_end && at_end < 1) ecp_i_shorter_way(c, h, &A, &B, at_a, at_b, n);
    ecp_i_sub(at_a, A.x, x);
    ecp_i_mul_t(A.Q, x, at_a);
    ecp_i_sub(at_b, B.x, x);
    ecp_i_mul_t(B.Q, x, at_b);
}

/* the gap of two points in the frames of A and B along n, at the end of the trial motion or at the
   beginning of the step */
static ecp_real ecp_i_gap_along(const ecp_i_pair *c, int at_end, const ecp_real a[3],
                                const ecp_real b[3], const ecp_real n[3])
{
    ecp_i_posed A, B;
    ecp_real x[3], y[3];
    ecp_i_poses(c, at_end, &A, &B);
    ecp_i_mul(A.Q, a, x);
    ecp_i_add(x, A.x, x);
    ecp_i_mul(B.Q, b, y);
    ecp_i_add(y, B.x, y);
    ecp_i_sub(y, x, y);
    return ecp_i_dot(n, y);
}

/* How far a pair overlaps at the beginning of the step, about, and the normal out of A. old: its patch of the
   last step. */
static ecp_real ecp_i_depth(const ecp_i_pair *c, const ecp_i_patch *old, ecp_real n[3])
{
    ecp_i_posed A, B;
    ecp_real a[3], b[3], gap;
    if (old && !old->guess) {
        ecp_i_scale(-1, old->contact.normal, n);
        return ecp_i_max(0, -old->contact.gap);
    }
    ecp_i_poses(c, 0, &A, &B);
    if (ecp_i_on_plane(c)) {
        gap = ecp_i_plane_gap(&A, &B, 0, n, a);
    } else {
        ecp_i_pair_nearest(c, 0, 0, a, b, n);
        gap = ecp_i_gap_along(c, 0, a, b, n);
    }
    return ecp_i_max(0, -gap);
}

/* The impulse to start with, for a predicted gap in h vs and the normal n out of A: the load where
   the bodies would overlap; and what hangs together as it falls (a stack) has its load as well. */
static ecp_real ecp_i_start_load(const ecp_i_pair *c, const ecp_real n[3], ecp_real gap)
{
    ecp_real weight = -ecp_i_dot(n, c->weight), p = ecp_i_min(1, ecp_i_max(0, -gap));
    if (ECP_I_PAIRS && c->carried == c->mb) weight = -weight;
    if (!ecp_i_on_plane(c) && !c->on_b->bears) return p;
    return ecp_i_max(p, ecp_i_min(weight, weight - gap));
}

#define ECP_I_FLAT ECP_R(1e-7)

/* Where A touches a half-space when the step begins, as it is posed then, and the normal. They stay as they are if it
   does not. */
static void ecp_i_touches(const ecp_i_pair *c, ecp_i_posed *A, ecp_real a[3], ecp_real n[3])
{
    ecp_i_posed A0, B0;
    ecp_real n0[3], at[3];
    ecp_i_poses(c, 0, &A0, &B0);
    if (ecp_i_plane_gap(&A0, &B0, ECP_I_FLAT, n0, at) >
        ecp_i_sqrt(ECP_I_EPSILON) * A0.shape->radius)
        return;
    ecp_i_sub(at, A0.x, at);
    ecp_i_mul_t(A0.Q, at, a);
    ecp_i_copy3(n0, n);
    *A = A0;
}

/* the geometry of a start: the ECP a, and the multipliers for the normal n out of A; b: the point of a pair's B */
static void ecp_i_start_at(ecp_i_pair *c, const ecp_i_posed *A, const ecp_i_posed *B,
                           const ecp_real a[3], const ecp_real b[3], const ecp_real n[3],
                           ecp_real *y)
{
    ecp_real local[3], back[3];
    ecp_i_scale(1 / c->L, a, y);
    /* (fa and ga have been room for others) */
    if (!ecp_i_on_plane(c)) c->placed = 0;
    ecp_i_pair_place(c, a);
    ecp_i_mul_t(A->Q, n, local);
    ecp_i_cone_multipliers(c->nl, c->fa, c->ga, local, ECP_R(1e-3) * c->a->shape.radius, y + 3);
    if (ecp_i_on_plane(c)) return;
    ecp_i_scale(-1, n, back);
    ecp_i_mul_t(B->Q, back, local);
    c->b->shape.cls->eval(&c->b->shape, b, c->on_b->fb, c->on_b->gb);
    ecp_i_cone_multipliers(c->nm, c->on_b->fb, c->on_b->gb, local, ECP_R(1e-3) * c->b->shape.radius,
                           y + ecp_i_at_m(c));
}

/* A geometric start at the present trial motion: support points, or nearest points, their
   normal-cone multipliers, and p_n on where the gap is negative. `guess`: an ECP (frame of A) to
   prefer, or NULL. flat: faces and edges inclined to a half-space by no more than this count as
   parallel to it. first: what touches a half-space when the step begins does so on the same face or edge still:
   its loads alone would tilt it (a pull at a box, in the first step of a world), the contact holds it. */
static void ecp_i_start_geometric(ecp_i_pair *c, ecp_real h, const ecp_real *guess, ecp_real flat,
                                  int first, ecp_real *y)
{
    ecp_i_posed A, B;
    ecp_real a[3], b[3], n[3], local[3], world_a[3], gap;
    int i;
    for (i = 0; i < c->count; i++) y[i] = 0;
    ecp_i_poses(c, 1, &A, &B);
    if (ecp_i_on_plane(c)) {
        gap = ecp_i_plane_gap(&A, &B, flat, n, world_a);
        ecp_i_sub(world_a, A.x, local);
        ecp_i_mul_t(A.Q, local, a);
    } else {
        ecp_i_pair_nearest(c, 1, h, a, b, n);
        gap = ecp_i_gap_along(c, 1, a, b, n);
        y[ecp_i_at_d(c)] = gap / (h * c->V);
    }
    /* only where the contact can be: not above the lowest points */
    if (guess && ecp_i_on_plane(c)) {
        ecp_i_sub(a, guess, b);
        ecp_i_mul(A.Q, b, local);
        if (ecp_i_dot(n, local) > ECP_R(1e-6) * c->a->shape.radius) guess = NULL;
    }
    if (guess)
        ecp_i_copy3(guess, a);
    else if (first && ecp_i_on_plane(c))
        ecp_i_touches(c, &A, a, n);
    ecp_i_start_at(c, &A, &B, a, b, n, y);
    if (!ecp_i_on_plane(c)) {
        ecp_i_add(c->offset, c->ra0, b);
        if (ecp_i_abs(gap) <= ECP_I_POSE_ROUNDING * ecp_i_gap_rounding(c, c->ra0, b)) gap = 0;
    }
    gap /= h * c->V;
    y[ecp_i_at_p(c)] = ecp_i_start_load(c, n, gap);
}
/* >>spots: a start from several points a patch. The patch at a trial pose is sampled at the points
   that are nearest when A is tilted a little to one of four sides, and at the nearest ones; with the
   geometry of these points as it is there, impulses and velocities by Gauss-Seidel sweeps (the normal
   impulse of each point, then the patch's friction, which as in the step's problem acts where these act
   together: friction in each point would make a torsion that the patch cannot bear); then the points at
   the pose that this leads to, again. What engines do in place of the step is good enough to tell which
   patches carry, where, and which slide. */

#define ECP_I_SPOTS 5
#define ECP_I_TILT ECP_R(0.02)
#define ECP_I_ROUNDS 4
#define ECP_I_SWEEPS 60

typedef struct ecp_i_spot {
    ecp_real a[3], b[3];   /* in the frames of the primitives */
    ecp_real ra[3], rb[3]; /* from the centres of mass, world */
    ecp_real gap;          /* over h, less what the trial motion closed of it */
    ecp_real W, p;         /* velocity per impulse along the normal; the impulse */
} ecp_i_spot;

/* the spots of a patch, in the memory of its Newton block */
typedef struct ecp_i_sample {
    ecp_i_spot spots[ECP_I_SPOTS];
    ecp_real y[3]; /* p_t / e_t, p_o / e_o, p_r / e_r */
    ecp_real rho;  /* bounds the velocity per impulse across, for all of y together */
} ecp_i_sample;

static ecp_i_sample *ecp_i_sample_of(const ecp_i_pair *c)
{
    return (ecp_i_sample *)(void *)c->block;
}

/* turns Q by the small rotation r */
static void ecp_i_tilt(const ecp_real r[3], ecp_real Q[9])
{
    ecp_real T[9], J[9], turned[9];
    int k;
    ecp_i_cayley(r, 1, T, J);
    ecp_i_matmul(T, Q, turned);
    for (k = 0; k < 9; k++) Q[k] += turned[k];
}

/* the points a and b that are nearest with A tilted to the side `side` of its normal n; 0 if it
   overlaps so */
static int ecp_i_tilted_nearest(const ecp_i_pair *c, const ecp_real n[3], const ecp_real side[3],
                                ecp_real a[3], ecp_real b[3])
{
    ecp_i_posed A, B;
    ecp_real tilt[3], x[3], normal[3];
    int at_end;
    for (at_end = 1; at_end >= 0; at_end--) {
        ecp_i_poses(c, at_end, &A, &B);
        ecp_i_cross(side, n, tilt);
        ecp_i_scale(ECP_I_TILT, tilt, tilt);
        ecp_i_tilt(tilt, A.Q);
        ecp_i_axpy(A.x, -2 * ECP_I_TILT * ecp_i_min(A.shape->radius, B.shape->radius), n, A.x);
        if (!(ecp_i_distance(&A, &B, x, b, normal) > 0)) continue;
        ecp_i_sub(x, A.x, x);
        ecp_i_mul_t(A.Q, x, a);
        ecp_i_sub(b, B.x, x);
        ecp_i_mul_t(B.Q, x, b);
        return 1;
    }
    return 0;
}

/* velocity change of a body by the impulse f at r from its centre of mass, and a torsion about N */
static void ecp_i_wrench_velocity(ecp_i_motion *m, const ecp_real f[3], const ecp_real r[3],
                                  ecp_real torsion, const ecp_real N[3], ecp_real dv[6])
{
    ecp_real wrench[6];
    ecp_i_copy3(f, wrench);
    ecp_i_scale(torsion, N, wrench + 3);
    ecp_i_add_cross(r, f, wrench + 3);
    ecp_i_velocity_change(m, wrench, dv);
}

/* the velocities (in m->residual) after an impulse f on A at the spot, and a torsion */
static void ecp_i_spot_push(const ecp_i_pair *c, const ecp_i_spot *k, const ecp_real f[3],
                            ecp_real torsion)
{
    ecp_real dv[6];
    int i;
    if (ecp_i_moves_a(c)) {
        ecp_i_wrench_velocity(c->ma, f, k->ra, torsion, c->N, dv);
        for (i = 0; i < 6; i++) c->ma->residual[i] += dv[i];
    }
    if (ecp_i_moves_b(c)) {
        ecp_i_wrench_velocity(c->mb, f, k->rb, torsion, c->N, dv);
        for (i = 0; i < 6; i++) c->mb->residual[i] -= dv[i];
    }
}

/* of A relative to B at the spot, for velocities va, vb */
static void ecp_i_spot_velocity(const ecp_i_spot *k, const ecp_real va[6], const ecp_real vb[6],
                                ecp_real u[3])
{
    ecp_i_relative_velocity(va, vb, k->ra, k->rb, u);
}

/* velocity along dir at the spot for a unit impulse along it */
static ecp_real ecp_i_spot_admittance(const ecp_i_pair *c, const ecp_i_spot *k,
                                      const ecp_real dir[3], ecp_real torsion)
{
    ecp_real dv[6], none[6] = {0, 0, 0, 0, 0, 0}, u[3], sum = 0;
    if (ecp_i_moves_a(c)) {
        ecp_i_wrench_velocity(c->ma, dir, k->ra, torsion, c->N, dv);
        ecp_i_spot_velocity(k, dv, none, u);
        sum += torsion > 0 ? ecp_i_dot(dv + 3, c->N) : ecp_i_dot(u, dir);
    }
    if (ecp_i_moves_b(c)) {
        ecp_i_wrench_velocity(c->mb, dir, k->rb, torsion, c->N, dv);
        ecp_i_spot_velocity(k, none, dv, u);
        sum -= torsion > 0 ? -ecp_i_dot(dv + 3, c->N) : ecp_i_dot(u, dir);
    }
    return sum;
}

/* Where spot i of a patch with a half-space is on A, at the trial pose: the farthest along n, which is tilted to a side
   but for the first. Returns the gap there. */
static ecp_real ecp_i_spot_on_plane(const ecp_i_pair *c, const ecp_i_posed *A, const ecp_i_posed *B,
                                    const ecp_real n[3], const ecp_real side[3], int i,
                                    ecp_real at[3])
{
    ecp_i_spot *s = ecp_i_sample_of(c)->spots + i;
    ecp_real local[3];
    ecp_i_axpy(n, i ? ECP_I_TILT : ECP_R(0), side, local);
    ecp_i_farthest(A, local, 0, at);
    ecp_i_sub(at, A->x, local);
    ecp_i_mul_t(A->Q, local, s->a);
    ecp_i_sub(at, B->x, local);
    return ecp_i_dot(c->N, local) - B->shape->size[3];
}

/* The same of two bodies: the nearest points with A tilted to the side, or where none are found those of the first
   spot, which are known. */
static ecp_real ecp_i_spot_on_pair(ecp_i_pair *c, const ecp_i_posed *A, const ecp_i_posed *B,
                                   const ecp_real n[3], const ecp_real side[3], int i,
                                   ecp_real at[3])
{
    ecp_i_spot *first = ecp_i_sample_of(c)->spots, *s = first + i;
    ecp_real local[3];
    if (i > 0 && !ecp_i_tilted_nearest(c, n, side, s->a, s->b)) {
        ecp_i_copy3(first->a, s->a);
        ecp_i_copy3(first->b, s->b);
    }
    ecp_i_mul(A->Q, s->a, at);
    ecp_i_add(at, A->x, at);
    ecp_i_mul(B->Q, s->b, local);
    ecp_i_add(local, B->x, local);
    ecp_i_sub(at, local, local);
    return ecp_i_dot(c->N, local);
}

/* velocity of the patch's friction for its unit impulse at the spot, at most */
static ecp_real ecp_i_spot_rho(const ecp_i_pair *c, const ecp_i_spot *s)
{
    static const ecp_real none[3] = {0, 0, 0};
    ecp_real rho = 0;
    int k;
    for (k = 0; k < ecp_i_nf(c); k++) {
        ecp_real W = ecp_i_spot_admittance(c, s, k == 0 ? c->t : k == 1 ? c->o : none, k > 1);
        rho += c->e[k] * c->e[k] * W;
    }
    return rho;
}

/* the spots of a patch at the trial pose; impulses stay */
static void ecp_i_spots_find(ecp_i_pair *c, ecp_real h)
{
    ecp_i_sample *sample = ecp_i_sample_of(c);
    ecp_i_spot *spots = sample->spots;
    ecp_i_posed A, B;
    ecp_real n[3], at[3], side[3], u[3];
    int i;
    ecp_i_poses(c, 1, &A, &B);
    if (ecp_i_on_plane(c))
        ecp_i_plane_gap(&A, &B, 0, n, at);
    else
        ecp_i_pair_nearest(c, 1, h, spots[0].a, spots[0].b, n);
    ecp_i_scale(-1, n, c->N);
    ecp_i_tangents(c);
    sample->rho = 0;
    for (i = 0; i < ECP_I_SPOTS; i++) {
        ecp_i_spot *s = spots + i;
        ecp_i_scale(i & 1 ? ECP_R(1) : ECP_R(-1), c->t, side);
        ecp_i_axpy(side, i & 2 ? ECP_R(1) : ECP_R(-1), c->o, side);
        s->gap = ecp_i_on_plane(c) ? ecp_i_spot_on_plane(c, &A, &B, n, side, i, at)
                                   : ecp_i_spot_on_pair(c, &A, &B, n, side, i, at);
        ecp_i_sub(at, c->ma->dx, s->ra);
        ecp_i_add(at, c->offset, s->rb);
        ecp_i_sub(s->rb, c->mb->dx, s->rb);
        ecp_i_spot_velocity(s, c->ma->v, c->mb->v, u);
        s->gap = s->gap / h - ecp_i_dot(c->N, u);
        s->W = ecp_i_spot_admittance(c, s, c->N, 0);
        /* convex in the place: holds between the spots */
        sample->rho = ecp_i_max(sample->rho, ecp_i_spot_rho(c, s));
    }
}

/* Where the normal impulses of the spots act together, as a spot of which ra, rb and p are known; 0 if there
   are none. */
static int ecp_i_sample_centre(const ecp_i_sample *sample, ecp_i_spot *at)
{
    const ecp_i_spot *spots = sample->spots;
    int i, k;
    at->p = 0;
    for (i = 0; i < ECP_I_SPOTS; i++) at->p += spots[i].p;
    for (k = 0; k < 3; k++) at->ra[k] = at->rb[k] = 0;
    if (!(at->p > 0)) return 0;
    for (i = 0; i < ECP_I_SPOTS; i++) {
        ecp_i_axpy(at->ra, spots[i].p / at->p, spots[i].ra, at->ra);
        ecp_i_axpy(at->rb, spots[i].p / at->p, spots[i].rb, at->rb);
    }
    return 1;
}

/* the velocities after so much of the friction y at the spot */
static void ecp_i_sample_rub(const ecp_i_pair *c, const ecp_i_spot *at, const ecp_real y[3],
                             ecp_real share)
{
    ecp_real f[3];
    ecp_i_scale(share * c->e[0] * y[0], c->t, f);
    ecp_i_axpy(f, share * c->e[1] * y[1], c->o, f);
    ecp_i_spot_push(c, at, f, ecp_i_nf(c) == 3 ? share * c->e[2] * y[2] : ECP_R(0));
}

/* The slip where friction acts, per e: its unknowns resist it. */
static void ecp_i_sample_slip(const ecp_i_pair *c, const ecp_i_spot *at, ecp_real w[3])
{
    ecp_real u[3], spin[3];
    ecp_i_spot_velocity(at, c->ma->residual, c->mb->residual, u);
    ecp_i_sub(c->ma->residual + 3, c->mb->residual + 3, spin);
    w[0] = c->e[0] * ecp_i_dot(c->t, u);
    w[1] = c->e[1] * ecp_i_dot(c->o, u);
    w[2] = ecp_i_nf(c) == 3 ? c->e[2] * ecp_i_dot(c->N, spin) : ECP_R(0);
}

/* friction at the spot where it acts, whose p is its load */
static void ecp_i_sample_friction(const ecp_i_pair *c, const ecp_i_spot *at, ecp_i_sample *sample)
{
    ecp_real w[3], change[3] = {0, 0, 0}, size = 0, limit = c->mu * at->p;
    int i;
    ecp_i_sample_slip(c, at, w);
    for (i = 0; i < ecp_i_nf(c); i++) {
        change[i] = sample->y[i];
        sample->y[i] -= w[i] / sample->rho;
        size += sample->y[i] * sample->y[i];
    }
    size = ecp_i_sqrt(size);
    for (i = 0; i < ecp_i_nf(c); i++) {
        if (size > limit) sample->y[i] *= limit / size;
        change[i] = sample->y[i] - change[i];
    }
    ecp_i_sample_rub(c, at, change, 1);
}

/* One visit of a patch: the normal impulses of its spots, then its friction. associated: what slips opens, by mu times
   the slip. */
static void ecp_i_sample_relax(const ecp_i_pair *c, int associated)
{
    ecp_i_sample *sample = ecp_i_sample_of(c);
    ecp_i_spot was, at;
    ecp_real u[3], f[3], w[3], p, opens = 0;
    int k, bears = ecp_i_sample_centre(sample, &was);
    if (associated && bears && ecp_i_nf(c) > 0) {
        ecp_i_sample_slip(c, &was, w);
        opens = c->mu * ecp_i_norm(w);
    }
    for (k = 0; k < ECP_I_SPOTS; k++) {
        ecp_i_spot *s = sample->spots + k;
        ecp_i_spot_velocity(s, c->ma->residual, c->mb->residual, u);
        p = ecp_i_max(0, s->p - (ecp_i_dot(c->N, u) + s->gap - opens) / s->W);
        ecp_i_scale(p - s->p, c->N, f);
        s->p = p;
        ecp_i_spot_push(c, s, f, 0);
    }
    if (ecp_i_nf(c) == 0) return;
    if (bears) ecp_i_sample_rub(c, &was, sample->y, -1);
    if (!ecp_i_sample_centre(sample, &at)) {
        for (k = 0; k < 3; k++) sample->y[k] = 0;
        return;
    }
    ecp_i_sample_rub(c, &at, sample->y, 1);
    ecp_i_sample_friction(c, &at, sample);
}

/* the patch's unknowns from its spots: the ECP is where their normal forces act together */
static void ecp_i_spots_gather(ecp_i_pair *c, ecp_real h, ecp_real *y)
{
    const ecp_i_sample *sample = ecp_i_sample_of(c);
    const ecp_i_spot *spots = sample->spots;
    ecp_i_posed A, B;
    ecp_real a[3] = {0, 0, 0}, b[3] = {0, 0, 0}, p = 0, n[3];
    int i, k;
    for (i = 0; i < ECP_I_SPOTS; i++) {
        p += spots[i].p;
        ecp_i_axpy(a, spots[i].p, spots[i].a, a);
        ecp_i_axpy(b, spots[i].p, spots[i].b, b);
    }
    if (!(p > 0)) {
        ecp_i_start_geometric(c, h, NULL, 0, 0, y);
        y[ecp_i_at_p(c)] = 0;
        return;
    }
    ecp_i_scale(1 / p, a, a);
    ecp_i_scale(1 / p, b, b);
    for (i = 0; i < c->count; i++) y[i] = 0;
    y[ecp_i_at_p(c)] = p / c->P;
    for (k = 0; k < ecp_i_nf(c); k++) y[ecp_i_at_p(c) + 1 + k] = sample->y[k] / c->P;
    ecp_i_scale(-1, c->N, n);
    ecp_i_poses(c, 1, &A, &B);
    ecp_i_start_at(c, &A, &B, a, b, n, y);
}

/* the velocities (in m->residual) with the impulses of the patch */
static void ecp_i_sample_apply(const ecp_i_pair *c)
{
    const ecp_i_sample *sample = ecp_i_sample_of(c);
    ecp_i_spot at;
    ecp_real f[3];
    int i;
    for (i = 0; i < ECP_I_SPOTS; i++) {
        ecp_i_scale(sample->spots[i].p, c->N, f);
        ecp_i_spot_push(c, sample->spots + i, f, 0);
    }
    if (ecp_i_nf(c) > 0 && ecp_i_sample_centre(sample, &at)) {
        ecp_i_sample_rub(c, &at, sample->y, 1);
    }
}

/* a change of a body's velocities in units of its unknowns */
static void ecp_i_start_motion(const ecp_i_motion *m, const ecp_real dv[6], ecp_real z[6])
{
    ecp_i_scale(1 / m->speed, dv, z);
    ecp_i_scale(m->length / m->speed, dv + 3, z + 3);
}

/* spots at the present poses, and where their impulses move the bodies */
static void ecp_i_spots_round(ecp_i_island *s, int associated, ecp_real *z)
{
    ecp_real dv[6];
    int i, j, sweep;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        for (j = 0; j < 6; j++) m->residual[j] = m->body->v[j] + m->body->v_carry[j] + m->free[j];
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        if (!ecp_i_moves_a(c)) ecp_i_copy(6, c->ma->v, c->ma->residual);
        if (!ecp_i_moves_b(c)) ecp_i_copy(6, c->mb->v, c->mb->residual);
        ecp_i_spots_find(c, s->h);
        ecp_i_sample_apply(c);
    }
    for (sweep = 0; sweep < ECP_I_SWEEPS; sweep++) {
        for (i = 0; i < s->pair_count; i++) {
            ecp_i_sample_relax(s->pairs[sweep & 1 ? s->pair_count - 1 - i : i], associated);
        }
    }
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        for (j = 0; j < 6; j++) dv[j] = m->residual[j] - m->body->v[j] - m->body->v_carry[j];
        ecp_i_start_motion(m, dv, z + 6 * i);
        ecp_i_move(m, s->h, dv);
    }
}

/* the start itself, from the geometric one; 0 without memory */
static int ecp_i_start_spots(ecp_i_island *s, int associated, ecp_real *z)
{
    int i, round;
    if (!s->tree.fronts) ecp_i_island_carve(s);
    ecp_i_release(s->arena, s->blocks_at, s->tree.stack);
    ecp_i_carve_blocks(s, s->arena);
    if (s->arena->overflow) return 0;
    for (i = 0; i < s->pair_count; i++) {
        ECPSIM_MEMSET(ecp_i_sample_of(s->pairs[i]), 0, sizeof(ecp_i_sample));
    }
    for (round = 0; round < ECP_I_ROUNDS; round++) ecp_i_spots_round(s, associated, z);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_spots_gather(s->pairs[i], s->h, z + s->pairs[i]->at);
    }
    return 1;
}

/* >>broad: which primitives can come near each other within the step */

/* Bounds of primitives at one time, and of where the free motion takes them from there. Two can meet
   if they are no farther apart than the difference of their displacements, and half as much again. */
typedef struct ecp_i_box {
    ecp_real lo[3], hi[3], dx_lo[3], dx_hi[3];
    int body, last; /* the body of all that is in it, ECP_I_FREE for several; the highest index */
    int quiet;      /* all that is in it may be left out of the step, see >>sleep */
} ecp_i_box;

/* Bounds of all primitives, and a binary tree over those of the bounded ones in the order of their
   places along a space-filling curve: node i has the children 2 i and 2 i + 1, the leaves are nodes
   `count` to 2 count - 1, and theirs are the primitives' boxes. A half-space keeps its normal in lo
   and its offset in hi[0]. */
typedef struct ecp_i_broad {
    ecp_i_box *boxes, *nodes;
    uint32_t *code;
    int *leaf, *sorted, *planes, *hits;
    int count, plane_count;
} ecp_i_broad;

static void ecp_i_carve_broad(ecp_i_arena *arena, int shapes, ecp_i_broad *b)
{
    b->hits = ecp_i_take_ints(arena, shapes);
    if (!ECP_I_PAIRS) return; /* every primitive against every half-space */
    b->boxes = (ecp_i_box *)ecp_i_take(arena, 2 * (size_t)shapes, sizeof(ecp_i_box));
    b->code = (uint32_t *)ecp_i_take(arena, (size_t)shapes, sizeof(uint32_t));
    b->leaf = ecp_i_take_ints(arena, 3 * shapes);
    if (!b->boxes || !b->leaf) return;
    b->nodes = b->boxes + shapes;
    b->sorted = b->leaf + shapes;
    b->planes = b->sorted + shapes;
}

static void ecp_i_box_join(const ecp_i_box *a, const ecp_i_box *b, ecp_i_box *out)
{
    int k;
    for (k = 0; k < 3; k++) {
        out->lo[k] = ecp_i_min(a->lo[k], b->lo[k]);
        out->hi[k] = ecp_i_max(a->hi[k], b->hi[k]);
        out->dx_lo[k] = ecp_i_min(a->dx_lo[k], b->dx_lo[k]);
        out->dx_hi[k] = ecp_i_max(a->dx_hi[k], b->dx_hi[k]);
    }
    out->body = a->body == b->body ? a->body : ECP_I_FREE;
    out->last = a->last > b->last ? a->last : b->last;
    out->quiet = a->quiet & b->quiet;
}

/* can the displacements of a and b, at their most different, and half as much again, close a gap? */
static int ecp_i_boxes_close(const ecp_i_box *a, const ecp_i_box *b, ecp_real gap2)
{
    ecp_real move2 = 0, most;
    int k;
    if (gap2 == 0) return 1;
    for (k = 0; k < 3; k++) {
        most = ecp_i_max(a->dx_hi[k] - b->dx_lo[k], b->dx_hi[k] - a->dx_lo[k]);
        move2 += most * most;
    }
    return gap2 <= ECP_R(2.25) * move2;
}

static int ecp_i_boxes_meet(const ecp_i_box *a, const ecp_i_box *b)
{
    ecp_real gap2 = 0, gap;
    int k;
    for (k = 0; k < 3; k++) {
        gap = ecp_i_max(a->lo[k] - b->hi[k], b->lo[k] - a->hi[k]);
        if (gap > 0) gap2 += gap * gap;
    }
    return ecp_i_boxes_close(a, b, gap2);
}

/* what a primitive's points are from its body's centre of mass, at most */
static ecp_real ecp_i_part_reach(const ecp_i_part *p)
{
    return ecp_i_norm(p->box_centre) + ecp_i_norm(p->box_half);
}

/* How far the primitive may go beyond its body's free displacement before a pair that was left out
   must be looked at again: what contacts do to a body at rest, half as much again for its turn, and
   a little of its size. reach: of ecp_i_part_reach */
static ecp_real ecp_i_margin(const ecp_i_part *p, const ecp_i_motion *m, ecp_real reach)
{
    if (p->shape.kind == ECP_HALF_SPACE) return 0;
    return m->drift + ECP_R(1.5) * reach * m->swing + ECP_R(1e-3) * p->shape.radius +
           8 * ECP_I_EPSILON * m->from_origin;
}

/* the primitive's box at the beginning of the step, `reach` wider on all sides, with its displacement;
   or at the end of it, from where it goes nowhere */
static void ecp_i_part_box(const ecp_i_part *p, const ecp_i_motion *m, int at_end, ecp_real reach,
                           ecp_i_box *box)
{
    const ecp_real *R = at_end ? m->R : m->R0, *centre = p->box_centre, *size = p->box_half;
    int k;
    box->body = p->body;
    /* what was left out is no patch of the last step (ecp_i_last_hits) and is looked at anew */
    box->quiet = m->quiet && m->body->asleep < 2 && !at_end;
    ecp_i_set3(0, 0, 0, box->dx_lo);
    if (!at_end) ecp_i_copy3(m->dx, box->dx_lo);
    ecp_i_copy3(box->dx_lo, box->dx_hi);
    if (p->shape.kind == ECP_HALF_SPACE) {
        ecp_real local[3], origin[3];
        ecp_i_mul(p->rotation, p->shape.size, local);
        ecp_i_mul(R, local, box->lo);
        ecp_i_mul(R, p->position, origin);
        ecp_i_add(origin, m->body->x, origin);
        if (at_end) ecp_i_add(origin, m->dx, origin);
        box->hi[0] = ecp_i_dot(box->lo, origin) + p->shape.size[3];
        return;
    }
    for (k = 0; k < 3; k++, R += 3) {
        ecp_real x = m->body->x[k] + (at_end ? m->dx[k] : ECP_R(0)), half = reach;
        x = x + R[0] * centre[0] + R[1] * centre[1] + R[2] * centre[2];
        half = half + ecp_i_abs(R[0]) * size[0] + ecp_i_abs(R[1]) * size[1];
        half += ecp_i_abs(R[2]) * size[2];
        box->lo[k] = x - half;
        box->hi[k] = x + half;
    }
}

/* can what is in the box reach the half-space? */
static int ecp_i_plane_meets(const ecp_i_box *plane, const ecp_i_box *box)
{
    ecp_real low = -plane->hi[0];
    int k;
    for (k = 0; k < 3; k++) {
        low += plane->lo[k] * (plane->lo[k] > 0 ? box->lo[k] : box->hi[k]);
    }
    return ecp_i_boxes_close(plane, box, low > 0 ? low * low : ECP_R(0));
}

/* ten bits of each coordinate, interleaved */
static uint32_t ecp_i_morton(const ecp_i_box *all, const ecp_i_box *box)
{
    uint32_t code = 0;
    int j;
    for (j = 0; j < 3; j++) {
        ecp_real size = all->hi[j] - all->lo[j];
        ecp_real at = (box->lo[j] / 2 + box->hi[j] / 2 - all->lo[j]) / size;
        uint32_t cell = at > 0 && at <= 1 ? (uint32_t)(at * 1023) : 0;
        cell = (cell | cell << 16) & 0x030000ffu; /* two zeros between the bits */
        cell = (cell | cell << 8) & 0x0300f00fu;
        cell = (cell | cell << 4) & 0x030c30c3u;
        cell = (cell | cell << 2) & 0x09249249u;
        code |= cell << j;
    }
    return code;
}

/* merge sort of leaf[] by code */
static void ecp_i_sort_leaves(ecp_i_broad *b)
{
    int width, at, i, j, k;
    for (width = 1; width < b->count; width *= 2) {
        for (at = 0; at < b->count; at += 2 * width) {
            int middle = at + width < b->count ? at + width : b->count;
            int end = at + 2 * width < b->count ? at + 2 * width : b->count;
            for (i = at, j = middle, k = at; k < end; k++) {
                int first = i < middle && (j >= end || b->code[b->leaf[i]] <= b->code[b->leaf[j]]);
                b->sorted[k] = first ? b->leaf[i++] : b->leaf[j++];
            }
        }
        for (k = 0; k < b->count; k++) b->leaf[k] = b->sorted[k];
    }
}

static const ecp_i_box *ecp_i_broad_node(const ecp_i_broad *b, int node)
{
    return node < b->count ? b->nodes + node : b->boxes + b->leaf[node - b->count];
}

/* the tree over the boxes of all shapes that are there; none where these are all of one body */
static void ecp_i_broad_build(ecp_i_broad *b, const ecp_i_part *parts, int shapes)
{
    ecp_i_box all;
    int i, bodies = 0;
    b->count = b->plane_count = 0;
    for (i = 0; i < shapes; i++) {
        if (parts[i].body == ECP_I_FREE) continue;
        if (parts[i].shape.kind == ECP_HALF_SPACE) {
            b->planes[b->plane_count++] = i;
            continue;
        }
        b->boxes[i].last = i;
        if (b->count == 0 || parts[i].body != parts[b->leaf[b->count - 1]].body) bodies++;
        b->leaf[b->count++] = i;
    }
    if (bodies < 2) b->count = 0;
    if (b->count == 0) return;
    all = b->boxes[b->leaf[0]];
    for (i = 1; i < b->count; i++) ecp_i_box_join(&all, b->boxes + b->leaf[i], &all);
    for (i = 0; i < b->count; i++) {
        b->code[b->leaf[i]] = ecp_i_morton(&all, b->boxes + b->leaf[i]);
    }
    ecp_i_sort_leaves(b);
    for (i = b->count - 1; i > 0; i--) {
        ecp_i_box_join(ecp_i_broad_node(b, 2 * i), ecp_i_broad_node(b, 2 * i + 1), b->nodes + i);
    }
}

/* inserts into an ascending list what is not in it; returns the new length */
static int ecp_i_insert_hit(int *hits, int count, int hit)
{
    int i, j = count;
    while (j > 0 && hits[j - 1] > hit) j--;
    if (j > 0 && hits[j - 1] == hit) return count;
    for (i = count; i > j; i--) hits[i] = hits[i - 1];
    hits[j] = hit;
    return count + 1;
}

/* Lists in b->hits, in ascending order, the primitives of other bodies after number `after` whose
   bounds meet those of primitive i (which is bounded), but for pairs of two quiet ones. Returns how
   many. */
static int ecp_i_broad_query(ecp_i_broad *b, int i, int after)
{
    int stack[64], depth = 0, found = 0, j, k;
    const ecp_i_box *box = b->boxes + i;
    if (b->count > 0) stack[depth++] = 1;
    while (depth > 0) {
        int node = stack[--depth];
        const ecp_i_box *met = ecp_i_broad_node(b, node);
        if (met->last <= after || met->body == box->body || (met->quiet & box->quiet)) continue;
        if (!ecp_i_boxes_meet(met, box)) continue;
        if (node < b->count) {
            stack[depth++] = 2 * node;
            stack[depth++] = 2 * node + 1;
        } else {
            b->hits[found++] = met->last;
        }
    }
    for (k = 0; k < b->plane_count; k++) {
        int plane = b->planes[k];
        if (plane > after && ecp_i_plane_meets(b->boxes + plane, box)) b->hits[found++] = plane;
    }
    for (j = 0, k = 0; k < found; k++) j = ecp_i_insert_hit(b->hits, j, b->hits[k]);
    return found;
}

/* the same for a half-space: all bounded primitives after it that reach into it */
static int ecp_i_broad_query_plane(ecp_i_broad *b, const ecp_i_part *parts, int shapes, int i)
{
    const ecp_i_box *plane = b->boxes + i;
    int j, found = 0;
    for (j = i + 1; j < shapes; j++) {
        if (parts[j].body == ECP_I_FREE || parts[j].shape.kind == ECP_HALF_SPACE) continue;
        if (plane->quiet & b->boxes[j].quiet) continue;
        if (ecp_i_plane_meets(plane, b->boxes + j)) b->hits[found++] = j;
    }
    return found;
}

/* either of the two; without pairs all half-spaces to a bounded primitive and the other way round */
static int ecp_i_candidates(ecp_i_broad *b, const ecp_i_part *parts, int shapes, int i, int after)
{
    int plane = parts[i].shape.kind == ECP_HALF_SPACE, found = 0, j;
    if (ECP_I_PAIRS && plane) return ecp_i_broad_query_plane(b, parts, shapes, i);
    if (ECP_I_PAIRS) return ecp_i_broad_query(b, i, after);
    for (j = after + 1; j < shapes; j++) {
        if (parts[j].body == ECP_I_FREE || j == i) continue;
        if (plane != (parts[j].shape.kind == ECP_HALF_SPACE)) b->hits[found++] = j;
    }
    return found;
}

/* >>step ================================================================================== */

/* two shapes i < j that touch at a corner when the step begins (ecp_i_meets_at_corner), and a direction in which they
   are apart then */
typedef struct ecp_i_corner {
    int i, j;
    ecp_real n[3];
} ecp_i_corner;

typedef struct ecp_i_step {
    ecp_world *w;
    ecp_real h;
    const ecp_options *o;
    ecp_report *r;
    int *cut; /* if not NULL set to 1 where an island is given up early, for shorter steps */
    int is_watched,
        has_sleepers; /* options.sleep is on; bodies whose flag is set may be left out of this step */
    ecp_i_arena arena;
    ecp_i_motion *motions;
    ecp_i_pair *pairs;
    int pair_count, without; /* patches; and so many of them that have no contact in the end */
    int *extra, extras;      /* pairs of shapes that turned out to touch after all */
    ecp_i_corner *corner;    /* pairs that are left out though they touch */
    int corners;
    int *bodies; /* of an island */
    ecp_i_broad broad;
    ecp_real *margins, *reaches; /* of each primitive, ecp_i_margin and ecp_i_part_reach */
    ecp_i_pair **members;
} ecp_i_step;

static int ecp_i_watched(const ecp_i_step *s) { return ECP_I_SLEEP && s->is_watched; }
static int ecp_i_sleepers(const ecp_i_step *s) { return ECP_I_SLEEP && s->has_sleepers; }
static int ecp_i_is_asleep(const ecp_i_motion *m) { return ECP_I_SLEEP && m->asleep; }

static ecp_status ecp_i_fail(ecp_report *r, ecp_status status, int body, int shape_a, int shape_b,
                             ecp_real value, ecp_real limit)
{
    r->status = status;
    r->body = body;
    r->shape_a = shape_a;
    r->shape_b = shape_b;
    r->value = value;
    r->limit = limit;
    return status;
}

/* >>memory: every block of a step is cut here, for ecp_world_memsize and for the step alike */

static void ecp_i_carve_step(ecp_i_arena *arena, int bodies, int shapes, int patches, ecp_i_step *s)
{
    s->motions = (ecp_i_motion *)ecp_i_take(arena, (size_t)bodies, sizeof(ecp_i_motion));
    s->margins = ecp_i_take_reals(arena, 2, shapes);
    ecp_i_carve_broad(arena, shapes, &s->broad);
    if (ECP_I_PAIRS)
        s->corner = (ecp_i_corner *)ecp_i_take(arena, (size_t)patches, sizeof(ecp_i_corner));
    s->bodies = ecp_i_take_ints(arena, bodies + 2 * patches + 2);
    if (!s->bodies || !s->margins) return;
    s->reaches = s->margins + shapes;
    s->extra = s->bodies + bodies;
}

/* for the pairs that are in the step */
static void ecp_i_carve_pairs(ecp_i_arena *arena, int pairs, ecp_i_step *s)
{
    s->pairs = (ecp_i_pair *)ecp_i_take(arena, (size_t)pairs, sizeof(ecp_i_pair));
}

static void ecp_i_carve_members(ecp_i_arena *arena, int pairs, ecp_i_step *s)
{
    s->members = (ecp_i_pair **)ecp_i_take(arena, (size_t)pairs, sizeof(ecp_i_pair *));
}

/* What an island leaves of its patches, zero. It takes the place of the memory in which the island was
   solved, and is less than that, so that nothing need be added for it. */
static void ecp_i_carve_records(ecp_i_step *s, int label)
{
    size_t bytes = sizeof(ecp_i_patch) + (size_t)s->w->desc.max_inequalities * sizeof(ecp_real);
    int i;
    for (i = s->motions[label].first_pair; i >= 0; i = s->pairs[i].next_pair) {
        ecp_i_pair *c = s->pairs + i;
        c->record = (ecp_i_patch *)ecp_i_take(&s->arena, bytes, 1);
        ECPSIM_ASSERT(c->record);
        ECPSIM_MEMSET(c->record, 0, bytes);
        c->multipliers = (ecp_real *)(void *)(c->record + 1);
    }
}

/* Values, gradients and lists of one patch with nl + nm multipliers; nm = 0: B is a half-space. Where
   sizes alone are added up (here and in ecp_i_carve_block) there is no patch. */
static void ecp_i_carve_pair(ecp_i_arena *arena, int nl, int nm, ecp_i_pair *c)
{
    size_t count = (size_t)(nl + nm), side = ECP_I_PAIRS && nm > 0 ? sizeof(ecp_i_side_b) : 0;
    unsigned char *block =
        (unsigned char *)ecp_i_take(arena, 1, side + count * (6 * sizeof(ecp_real) + sizeof(int)));
    ecp_i_side_b *b = (ecp_i_side_b *)(void *)block;
    int *ints;
    if (!block) return;
    c->fa = (ecp_real *)(void *)(block + side);
    ints = (int *)(void *)(c->fa + 6 * count);
    c->fixed_a = c->fa + nl;
    c->slope_a = c->fixed_a + nl;
    c->ga = c->slope_a + nl;
    c->active_a = ints;
    if (side == 0) return;
    c->on_b = b;
    b->fb = c->ga + 3 * nl;
    b->fixed_b = b->fb + nm;
    b->slope_b = b->fixed_b + nm;
    b->gb = b->slope_b + nm;
    b->active_b = ints + nl;
}

/* The vectors of Newton's method: z, F; and where the first residual will not do, the last z that a
   ramp or continuation has reached or to which a centring step goes back, dz, trial, drift, and where
   Newton has stalled before the working set or continuation. */
#define ECP_I_VECTORS                                                                              \
    ((ECPSIM_FALLBACKS) & (ECP_FALLBACK_CONTINUATION | ECP_FALLBACK_WORKING_SET) ? 7 : 6)

static void ecp_i_carve_vectors(ecp_i_arena *arena, int unknowns, ecp_real *vectors[ECP_I_VECTORS])
{
    int k;
    vectors[0] = ecp_i_take_reals(arena, unknowns, ECP_I_VECTORS);
    for (k = 1; k < ECP_I_VECTORS; k++) vectors[k] = vectors[0] ? vectors[k - 1] + unknowns : NULL;
}

/* unknowns of a patch with all friction rows that there are, and all multipliers that the description allows */
static int ecp_i_most_unknowns(const ecp_world_desc *d)
{
    return 4 + ECP_I_PAIRS + 3 * ECP_I_FRICTION + d->max_inequalities;
}

/* What a patch can leave to the front. With a half-space: the ECP and the impulses, where no multiplier is kept; each
   that is kept fixes the normal in one direction, and itself. */
static int ecp_i_most_left(const ecp_world_desc *d)
{
    int kept = d->max_inequalities > 2 ? 2 : d->max_inequalities;
    return ecp_i_most_unknowns(d) - (ECP_I_PAIRS ? 0 : kept);
}

/* what ecp_i_block_pack keeps of a block of n unknowns and so many pivots, in reals */
static int ecp_i_packed(int n, int pivots)
{
    int left = n - pivots;
    return pivots * (n + 7) + left * 7 + 6 * (left + 7);
}

/* What it keeps at most beside what the front has for a patch, 14 reals for each unknown that is left
   (ecp_i_tree_reals): together they grow or shrink by the same with each pivot, so the most is with the fewest pivots,
   or with all. */
static int ecp_i_most_packed(const ecp_world_desc *d)
{
    int n = ecp_i_most_unknowns(d), left = ecp_i_most_left(d);
    int few = ecp_i_packed(n, n - left), all = ecp_i_packed(n, n) - 14 * left;
    return few > all ? few : all;
}

/* bodies of one island */
static int ecp_i_most_together(const ecp_world_desc *d) { return ECP_I_PAIRS ? d->max_bodies : 1; }

/* What the fronts of one island may need, in reals. Exact for what matters on a microcontroller (one
   body, whatever its patches); for more bodies an estimate: each is taken to have 12 neighbours when
   it is eliminated, and a patch of many to leave 8 rows. */
static size_t ecp_i_tree_reals(const ecp_world_desc *d)
{
    size_t n = (size_t)ecp_i_most_together(d), patches = (size_t)d->max_patches;
    size_t u = 6 * (n - 1 < 12 ? n - 1 : 12), few = n > 8 && u > 18 ? 18 : u;
    size_t left = n > 8 ? 8 : (size_t)ecp_i_most_left(d);
    size_t met = patches * left + n * u, front = (n > 8 ? 32 * left : met) + ECP_I_ROWS_FOR_PARENT;
    size_t rows = met + ECP_I_ROWS_FOR_PARENT * n;
    return n * ((ECP_I_PAIRS ? 19 : 13) * (7 + u) + u + 12) + rows * (7 + u) + /* lasting */
           (ECP_I_PAIRS ? n * (9 * u + 24) + met * 6 + rows * few : 0) +       /* kept */
           front * (7 + u) + (6 + u) * (7 + u) + (n + 1) * 2 * u * (u + 1);    /* stack */
}

/* of ecp_advance */
#define ECP_I_MAX_ORDER 12

/* a time that never comes, s */
#define ECP_I_NEVER ECP_R(1e30)

/* reals of the tableau for each patch that carries: forces of the last base step, and the ECP in the frame of A, and
   of B (of a half-space it says nothing) */
#define ECP_I_FORCES (ECP_I_PAIRS ? 10 : 7)

/* what a patch that carries does in one base step */
typedef struct ecp_i_phase {
    int shape_a, shape_b;
    ecp_mode mode;
    int no_lead;           /* the columns begin without a lead-in of it */
    uint64_t faces[2];     /* which multipliers are on, of A and of B (beyond 64: folded) */
    ecp_real a[3], N[3];   /* the ECP in the frame of A; the normal */
    ecp_real friction[4];  /* its impulse, and its moment about the normal */
    ecp_real p_n[2], y[2]; /* normal impulse, and friction over mu: the first base steps of the
                              first two columns */
    ecp_real mu, weigh[3]; /* weigh: 1 / e, to make p_t, p_o, p_r comparable */
    ecp_real margin[3], rate[3]; /* how far the load is from zero, friction from its limit, the ECP
                                    from a face's rim, and their rates of change */
} ecp_i_phase;

typedef struct ecp_i_advance {
    ecp_world *w;
    ecp_advance_options o;
    ecp_options step;
    ecp_advance_report *r;
    size_t bytes;                 /* of all this, at the end of the block */
    unsigned char *first, *saved; /* the state at the beginning, of all and of the macro step */
    ecp_real *rows; /* of the tableau: 12 reals for each body, and ECP_I_FORCES for each patch that
                       carries */
    int row;        /* reals in a row */
    ecp_real *rate, *rate_now; /* dv / h in the last base step of the last macro step, and of this
                                     one; 6 reals for each body */
    ecp_real *values;          /* f, and 3 reals of gradient, of one primitive */
    ecp_i_phase *last, *now, *here; /* of the last base step so far, of this macro step, of one */
    int last_count, now_count;
    ecp_real t, H;
    ecp_real lead;     /* 1: ahead, -1: back; see ecp_i_lead_in */
    ecp_real push;     /* the largest acceleration by gravity or loads, as the macro step begins */
    int changed;       /* the phases are not the same in all base steps */
    int brief;         /* something changes at the beginning that only a brief macro step shows */
    int impact;        /* and something, without a trace in the forces, that need not be brief */
    ecp_real nearest;  /* how long until what is not yet so at the beginning, about */
    ecp_i_phase ahead; /* and which phase that is, from a macro step that was too long */
    int looking;       /* `ahead` means something */
    int exact;         /* `nearest` is as exact as the rates are */
    ecp_real drift;    /* how long the state may go on as it does, until what is as exact */
} ecp_i_advance;

/* the bytes of all that: two states and the arrays, each rounded up */
static size_t ecp_i_advance_bytes(const ecp_world *w)
{
    const ecp_world_desc *d = &w->desc;
    size_t bodies = (size_t)d->max_bodies, patches = (size_t)d->max_patches;
    size_t row = 12 * bodies + ECP_I_FORCES * patches;
    size_t reals = row * (size_t)d->advance_order + 12 * bodies + 4 * (size_t)d->max_inequalities;
    return 2 * w->state_bytes + reals * sizeof(ecp_real) + 3 * patches * sizeof(ecp_i_phase) + 64;
}

static void ecp_i_carve_world(ecp_i_arena *arena, ecp_world *w)
{
    const ecp_world_desc *d = &w->desc;
    ecp_i_step s;
    ecp_i_tree t;
    ecp_i_graph g;
    ecp_real *vectors[ECP_I_VECTORS];
    int i, most = ecp_i_most_unknowns(d), packed = ecp_i_most_packed(d);
    size_t reals = ecp_i_tree_reals(d), whole = (size_t)((most + 6) * (most + 7) - packed);
    ecp_i_carve_state(arena, w);
    ecp_i_carve_step(arena, d->max_bodies, d->max_shapes, d->max_patches, &s);
    ecp_i_carve_pairs(arena, d->max_patches, &s);
    ecp_i_carve_members(arena, d->max_patches, &s);
    for (i = 0; i < d->max_patches; i++) {
        ecp_i_carve_pair(arena, d->max_inequalities - 1, 1, NULL);
        if (ECP_I_PAIRS) {
            ecp_i_carve_block(arena, most, ECP_I_MOVERS, NULL);
            continue;
        }
        ecp_i_take_ints(arena, 3 * most);
        ecp_i_take_reals(arena, packed, 1);
    }
    /* the last block as a whole: the front comes after that */
    if (!ECP_I_PAIRS && reals < whole) reals = whole;
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_SUBSTEPS) ecp_i_take(arena, w->state_bytes, 1); /* before */
    ecp_i_carve_vectors(arena, 6 * ecp_i_most_together(d) + most * d->max_patches, vectors);
    ecp_i_carve_tree(arena, ecp_i_most_together(d), &t, &g);
    if (d->solver_bytes > 0)
        ecp_i_take(arena, d->solver_bytes, 1);
    else
        ecp_i_take(arena, reals, sizeof(ecp_real));
    if (d->advance_order > 0) ecp_i_take(arena, ecp_i_advance_bytes(w), 1);
    w->bytes = arena->used;
}

static int ecp_i_desc_ok(const ecp_world_desc *d)
{
    return d->max_bodies >= 1 && d->max_bodies <= 4096 && d->max_shapes >= 1 &&
           d->max_shapes <= 100000 && d->max_patches >= 1 && d->max_patches <= 100000 &&
           d->max_inequalities >= 1 && d->max_inequalities <= 1000 &&
           (d->advance_order == 0 ||
            (d->advance_order >= 2 && d->advance_order <= ECP_I_MAX_ORDER));
}

/* The world of a description, with where everything is in its block. Returns how long that is; 0: more than can be
   addressed. */
static size_t ecp_i_plan_world(const ecp_world_desc *desc, ecp_world *w)
{
    ecp_i_arena arena = ecp_i_arena_over(NULL, 0);
    ECPSIM_MEMSET(w, 0, sizeof *w);
    /* field by field: padding stays zero, and equal worlds are equal bytes */
    w->desc.max_bodies = desc->max_bodies;
    w->desc.max_shapes = desc->max_shapes;
    w->desc.max_patches = desc->max_patches;
    w->desc.max_inequalities = desc->max_inequalities;
    w->desc.solver_bytes = desc->solver_bytes;
    w->desc.advance_order = desc->advance_order;
    ecp_i_copy3(desc->gravity, w->desc.gravity);
    ecp_i_carve_world(&arena, w);
    return arena.overflow ? 0 : arena.used;
}

ECP_DEF size_t ecp_world_memsize(const ecp_world_desc *desc)
{
    ecp_world w;
    return desc && ecp_i_desc_ok(desc) ? ecp_i_plan_world(desc, &w) : 0;
}

ECP_DEF ecp_status ecp_world_init(ecp_world **world, const ecp_world_desc *desc, void *mem,
                                  size_t bytes)
{
    ecp_world w;
    size_t need;
    if (!world || !desc || !mem) return ECP_BAD_POINTER;
    if (!ecp_i_desc_ok(desc)) return ECP_BAD_OPTION;
    if (!ecp_i_all_finite(3, desc->gravity)) return ECP_NOT_FINITE;
    if (((size_t)mem & 7) != 0) return ECP_MEMORY_ALIGN;
    need = ecp_i_plan_world(desc, &w);
    if (need == 0) return ECP_BAD_OPTION;
    if (bytes < need) return ECP_MEMORY_SMALL;
    ECPSIM_MEMSET(mem, 0, need);
    ECPSIM_MEMCPY(mem, &w, sizeof w);
    *world = (ecp_world *)mem;
    return ECP_OK;
}

/* >>patches: which pairs of primitives are in the step's problem */

/* the primitives i < j as a pair and where they are, without the rest of it; 0 if they never make a
   patch */
static int ecp_i_pair_bind(const ecp_i_step *s, int i, int j, ecp_i_pair *c)
{
    const ecp_i_part *parts = ecp_i_parts(s->w);
    int swap = parts[i].shape.kind == ECP_HALF_SPACE;
    const ecp_i_part *a = parts + (swap ? j : i), *b = parts + (swap ? i : j);
    ecp_i_motion *ma, *mb;
    if (!ecp_i_may_meet(a, b)) return 0;
    ma = s->motions + a->body;
    mb = s->motions + b->body;
    if (a->shape.kind == ECP_HALF_SPACE || ma == mb || (!ma->dynamic && !mb->dynamic)) return 0;
    c->shape_a = swap ? j : i;
    c->shape_b = swap ? i : j;
    c->a = a;
    c->b = b;
    c->ma = ma;
    c->mb = mb;
    c->plane = b->shape.kind == ECP_HALF_SPACE;
    ecp_i_sub(ma->body->x, mb->body->x, c->offset);
    ecp_i_add(c->offset, ma->body->x_carry, c->offset);
    ecp_i_sub(c->offset, mb->body->x_carry, c->offset);
    return 1;
}

/* are two primitives no farther apart than that? */
static int ecp_i_closer(const ecp_i_posed *A, const ecp_i_posed *B, ecp_real reach)
{
    ecp_real n[3], at_a[3], at_b[3];
    ecp_i_posed_centre(A, at_a);
    ecp_i_posed_centre(B, at_b);
    ecp_i_sub(at_b, at_a, n);
    if (ecp_i_norm(n) - A->shape->radius - B->shape->radius > reach) return 0;
    if (ecp_i_normalise(n) && ecp_i_separation(A, B, n) > reach) return 0;
    return ecp_i_distance(A, B, at_a, at_b, n) <= reach;
}

/* Can the two touch within the step? Asked at the beginning of the step, of the free motion, with
   half as much again for what contacts do to it; what this misses is found by ecp_i_find_touching.
   old: the pair's patch of the last step, or NULL; it knows the gap at its end. */
static int ecp_i_near(const ecp_i_step *s, const ecp_i_pair *c, const ecp_i_patch *old)
{
    ecp_i_posed A, B;
    ecp_real n[3], at_a[3], move[3], reach;
    int known = old && !old->guess;
    if (known && old->contact.gap <= s->margins[c->shape_a] + s->margins[c->shape_b]) return 1;
    ecp_i_sub(c->ma->dx, c->mb->dx, move);
    reach = ECP_R(1.5) * ecp_i_norm(move) + s->margins[c->shape_a] + s->margins[c->shape_b];
    if (known && old->contact.gap <= reach) return 1;
    ecp_i_poses(c, 0, &A, &B);
    if (ecp_i_on_plane(c)) {
        if (c->mb->body->kind == ECP_KINEMATIC) {
            reach += ECP_R(1.5) * s->h * ecp_i_norm(c->mb->v + 3) *
                     (ecp_i_norm(A.x) + ecp_i_norm(c->offset) + c->a->shape.radius);
        }
        return ecp_i_plane_gap(&A, &B, 0, n, at_a) <= reach;
    }
    return ecp_i_closer(&A, &B, reach);
}

/* How far apart A and B are, at most, along the normals of their faces within `reach` of the points at[0] of A and
   at[1] of B, B as it touches A (ecp_i_move_apart); but not along such as are as good as n, by more than `cosine`.
   best: what there is without them. f: room for the values and gradients of a primitive. */
static ecp_real ecp_i_faces_apart(const ecp_i_posed *A, const ecp_i_posed *B,
                                  const ecp_i_posed *moved, ecp_real at[2][3], ecp_real reach,
                                  const ecp_real n[3], ecp_real cosine, ecp_real best, ecp_real *f)
{
    ecp_real local[3], out[3];
    int side, i;
    for (side = 0; side < 2; side++) {
        const ecp_i_posed *p = side ? moved : A;
        int count = p->shape->inequalities;
        ecp_real *g = f + count;
        ecp_i_sub(at[side], p->x, out);
        ecp_i_mul_t(p->Q, out, local);
        p->shape->cls->eval(p->shape, local, f, g);
        for (i = 0; i < count; i++) {
            if (f[i] < -reach) continue;
            ecp_i_mul(p->Q, g + 3 * i, out);
            if (side) ecp_i_scale(-1, out, out);
            if (!ecp_i_normalise(out) || ecp_i_dot(out, n) > cosine) continue;
            best = ecp_i_max(best, ecp_i_separation(A, B, out));
        }
    }
    return best;
}

/* Do two that touch meet at a corner, edge along edge or vertex to vertex, as boxes of a grid do across it? Then there
   is a second direction, a normal of a face at the nearest points, in which they are no deeper in each other than
   along the normal n, and their normal may be any between the two. While such a contact carries nothing it holds
   nothing either, but its normal turns by what the two move over a gap of nothing, and one such patch keeps Newton
   from all the others. f: room for the values and gradients of the two primitives. */
static int ecp_i_meets_at_corner(const ecp_i_pair *c, ecp_real *f, ecp_real n[3])
{
    ecp_i_posed A, B, apart;
    ecp_real at[2][3], gap, slack = ecp_i_slack(c);
    ecp_i_poses(c, 0, &A, &B);
    apart = B;
    gap = ecp_i_distance(&A, &B, at[0], at[1], n);
    if (gap > slack) return 0;
    if (!(gap > 0)) ecp_i_move_apart(&A, &apart, at[0], at[1], n);
    if (ecp_i_separation(&A, &B, n) < -slack) return 0;
    return ecp_i_faces_apart(&A, &B, &apart, at, 4 * slack, n, ECP_R(0.999), -2 * slack, f) >=
           -slack;
}

/* Is the pair left out, as a corner that carries nothing? Then it is listed, and looked at once more at the end of
   the step (ecp_i_find_corners). */
static int ecp_i_leaves_corner(ecp_i_step *s, const ecp_i_pair *c, const ecp_i_patch *old, int i,
                               int j)
{
    size_t mark = s->arena.used;
    ecp_i_corner *corner;
    ecp_real *room;
    int count, found;
    if (!ECP_I_PAIRS || ecp_i_on_plane(c) || s->corners == s->w->desc.max_patches) return 0;
    if (old && (old->guess || old->contact.p_n > 0 || old->contact.gap > ecp_i_slack(c))) return 0;
    corner = s->corner + s->corners;
    count = c->a->shape.inequalities;
    if (count < c->b->shape.inequalities) count = c->b->shape.inequalities;
    room = ecp_i_take_reals(&s->arena, 4, count);
    found = room && ecp_i_meets_at_corner(c, room, corner->n);
    /* zero again, for the next pair */
    if (room) ECPSIM_MEMSET(room, 0, 4 * (size_t)count * sizeof(ecp_real));
    s->arena.used = mark;
    if (!found) return 0;
    corner->i = i;
    corner->j = j;
    s->corners++;
    return 1;
}

/* by how much the certificate of a pair lets it overlap */
static ecp_real ecp_i_let_pass(const ecp_i_pair *c, ecp_real tolerance)
{
    ecp_real size = ecp_i_min(c->a->shape.radius, c->b->shape.radius);
    return 4 * tolerance * size + ECP_I_EPSILON * (ecp_i_norm(c->offset) + size);
}

/* Do the two overlap at the end of the trial motion, a pair of bodies by more than the certificate of a patch lets
   pass? along: a direction in which they were apart, and most often still are; or NULL. */
static int ecp_i_touching(const ecp_i_step *s, const ecp_i_pair *c, const ecp_real *along)
{
    ecp_i_posed A, B;
    ecp_real n[3], at_a[3], limit;
    ecp_i_poses(c, 1, &A, &B);
    if (ecp_i_on_plane(c)) return ecp_i_plane_gap(&A, &B, 0, n, at_a) < 0;
    limit = ecp_i_let_pass(c, s->o->tolerance);
    if (along && ecp_i_separation(&A, &B, along) >= -limit) return 0;
    if (!ecp_i_closer(&A, &B, 0)) return 0;
    /* where the search for n has met rounding first (in float, of a long rail beside a small body), what it makes of
       its last points is nothing, and n may be any */
    return ecp_i_overlap(&A, &B, n) > limit ||
           ecp_i_separation(&A, &B, n) <
               -limit - ECP_R(1e-6) * ecp_i_min(A.shape->radius, B.shape->radius);
}

/* the geometric mean; by two roots where the product is beyond the reals */
static ecp_real ecp_i_mean(ecp_real a, ecp_real b)
{
    ecp_real product = a * b;
    if (a == b) return a;
    if (product >= ECP_I_SMALLEST && ecp_i_finite(product)) return ecp_i_sqrt(product);
    return ecp_i_sqrt(a) * ecp_i_sqrt(b);
}

/* zero before, and where there is no friction */
static void ecp_i_pair_friction(ecp_i_pair *c)
{
    const ecp_material *a = &c->a->material, *b = &c->b->material, *own;
    ecp_real local[3], unit;
    int first_a = c->shape_a < c->shape_b, directed_a, directed_b, k;
    if (!ECP_I_FRICTION) return;
    c->mu = ecp_i_mean(a->mu, b->mu);
    c->e[0] = ecp_i_mean(a->e_t, b->e_t);
    c->e[1] = ecp_i_mean(a->e_o, b->e_o);
    c->e[2] = ecp_i_mean(a->e_r, b->e_r);
    c->nf = c->mu > 0 ? (c->e[2] > 0 ? 3 : 2) : 0;
    directed_a = !ecp_i_is_zero(a->direction);
    directed_b = !ecp_i_is_zero(b->direction);
    if (!directed_a && !directed_b) return;
    own = directed_a && (first_a || !directed_b) ? a : b;
    unit = ecp_i_power_of_two(ecp_i_row_size(3, own->direction));
    for (k = 0; k < 3; k++) c->direction[k] = own->direction[k] / unit;
    ecp_i_mul((own == a ? c->a : c->b)->rotation, c->direction, local);
    ecp_i_mul((own == a ? c->ma : c->mb)->R0, local, c->direction);
    ecp_i_normalise(c->direction);
}

/* the rest of it, zero before; old: its patch in the world's list, or -1 */
static void ecp_i_pair_setup(ecp_i_pair *c, int old)
{
    c->nl = c->a->shape.inequalities;
    c->nm = ecp_i_on_plane(c) ? 0 : c->b->shape.inequalities;
    ecp_i_pair_friction(c);
    c->count = ecp_i_at_p(c) + 1 + ecp_i_nf(c);
    c->old = old;
}

static int ecp_i_is_extra(const ecp_i_step *s, int i, int j)
{
    int k;
    for (k = 0; k < s->extras; k++) {
        if (s->extra[2 * k] == i && s->extra[2 * k + 1] == j) return 1;
    }
    return 0;
}

/* the order of the world's list of patches: by the lower index of the two shapes, then the higher */
static int ecp_i_patch_before(const ecp_i_patch *p, int i, int j)
{
    int lo = p->contact.shape_a < p->contact.shape_b ? p->contact.shape_a : p->contact.shape_b;
    int hi = p->contact.shape_a < p->contact.shape_b ? p->contact.shape_b : p->contact.shape_a;
    return lo < i || (lo == i && hi < j);
}

static int ecp_i_patch_is(const ecp_i_patch *p, int i, int j)
{
    return (p->contact.shape_a == i && p->contact.shape_b == j) ||
           (p->contact.shape_a == j && p->contact.shape_b == i);
}

/* Adds the pair of i < j if it can touch, at the end of those that begin at `begin`. *next: where the
   search in the world's list goes on. */
static ecp_status ecp_i_add_pair(ecp_i_step *s, size_t begin, int i, int j, int *next)
{
    const ecp_i_patch *list = ecp_i_patches(s->w), *old = NULL;
    ecp_i_pair *c;
    int inequalities;
    s->arena.used = begin;
    ecp_i_carve_pairs(&s->arena, s->pair_count + 1, s);
    ECPSIM_ASSERT(s->pairs);
    c = s->pairs + s->pair_count;
    if (!ecp_i_pair_bind(s, i, j, c)) return ECP_OK;
    while (*next < s->w->patches && ecp_i_patch_before(list + *next, i, j)) ++*next;
    if (*next < s->w->patches && ecp_i_patch_is(list + *next, i, j)) old = list + *next;
    if (!ecp_i_is_extra(s, i, j) &&
        (!ecp_i_near(s, c, old) || ecp_i_leaves_corner(s, c, old, i, j)))
        return ECP_OK;
    if (s->pair_count == s->w->desc.max_patches) {
        return ecp_i_fail(s->r, ECP_CAPACITY, -1, i, j, (ecp_real)(s->pair_count + 1),
                          (ecp_real)s->w->desc.max_patches);
    }
    inequalities = c->a->shape.inequalities + (ecp_i_on_plane(c) ? 0 : c->b->shape.inequalities);
    /* (one primitive alone has no more: ecp_body_add_shape) */
    if (ECP_I_PAIRS && inequalities > s->w->desc.max_inequalities) {
        return ecp_i_fail(s->r, ECP_CAPACITY, -1, i, j, (ecp_real)inequalities,
                          (ecp_real)s->w->desc.max_inequalities);
    }
    ecp_i_pair_setup(c, old ? *next : -1);
    s->pair_count++;
    return ECP_OK;
}

/* Adds to the hits of i, which is quiet, what made a patch with it in the last step and is quiet too:
   nothing about such a pair has changed. */
static int ecp_i_last_hits(const ecp_i_step *s, int i, int at, int *hits, int found)
{
    const ecp_i_patch *list = ecp_i_patches(s->w);
    while (at < s->w->patches && ecp_i_patch_before(list + at, i, 0)) at++;
    for (; at < s->w->patches; at++) {
        const ecp_contact *c = &list[at].contact;
        int other = c->shape_a == i ? c->shape_b : c->shape_a;
        if (other < i || (c->shape_a != i && c->shape_b != i)) break;
        if (!s->motions[ecp_i_parts(s->w)[other].body].quiet) continue;
        found = ecp_i_insert_hit(hits, found, other);
    }
    return found;
}

/* the pairs of primitives that can touch, and the memory for their patches */
static ecp_status ecp_i_find_pairs(ecp_i_step *s)
{
    const ecp_i_part *parts = ecp_i_parts(s->w);
    ecp_i_broad *b = &s->broad;
    ecp_status status = ECP_OK;
    size_t begin = s->arena.used;
    int i, k, found, next = 0, shapes = s->w->shapes;
    for (i = 0; i < shapes; i++) {
        const ecp_i_motion *m;
        if (parts[i].body == ECP_I_FREE) continue;
        m = s->motions + parts[i].body;
        s->reaches[i] = ecp_i_part_reach(parts + i);
        s->margins[i] = ecp_i_margin(parts + i, m, s->reaches[i]);
        if (!ECP_I_PAIRS) continue;
        ecp_i_part_box(parts + i, m, 0, s->margins[i], b->boxes + i);
        /* a half-space that moves is left to ecp_i_near */
        if (parts[i].shape.kind == ECP_HALF_SPACE && m->body->kind == ECP_KINEMATIC) {
            ecp_i_set3(0, 0, 0, b->boxes[i].lo);
            b->boxes[i].hi[0] = 0;
        }
    }
    if (ECP_I_PAIRS) ecp_i_broad_build(b, parts, shapes);
    s->pair_count = 0;
    if (ECP_I_PAIRS) s->corners = 0;
    for (i = 0; i < shapes; i++) {
        if (parts[i].body == ECP_I_FREE) continue;
        found = ecp_i_candidates(b, parts, shapes, i, i);
        if (ECP_I_PAIRS && b->boxes[i].quiet) found = ecp_i_last_hits(s, i, next, b->hits, found);
        /* (without pairs these are candidates all the same) */
        for (k = 0; ECP_I_PAIRS && k < s->extras; k++) {
            if (s->extra[2 * k] == i) found = ecp_i_insert_hit(b->hits, found, s->extra[2 * k + 1]);
        }
        for (k = 0; k < found && status == ECP_OK; k++) {
            status = ecp_i_add_pair(s, begin, i, b->hits[k], &next);
        }
    }
    if (status != ECP_OK) return status;
    /* the last one that was looked at may not be in the step */
    if (s->arena.used > begin) {
        ECPSIM_MEMSET(
            s->pairs + s->pair_count, 0,
            (size_t)(s->arena.base + s->arena.used - (unsigned char *)(s->pairs + s->pair_count)));
    }
    s->arena.used = begin;
    ecp_i_carve_pairs(&s->arena, s->pair_count, s);
    ecp_i_carve_members(&s->arena, s->pair_count, s);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_carve_pair(&s->arena, s->pairs[i].nl, ecp_i_nm(s->pairs + i), s->pairs + i);
    }
    return ECP_OK;
}

/* is the pair of i < j in the step? */
static int ecp_i_is_in(const ecp_i_step *s, int i, int j)
{
    int lo = 0, hi = s->pair_count;
    while (lo < hi) {
        int middle = lo + (hi - lo) / 2, a = s->pairs[middle].shape_a, b = s->pairs[middle].shape_b;
        int first = a < b ? a : b;
        if (first == i && a + b == i + j) return 1;
        if (first < i || (first == i && a + b < i + j))
            lo = middle + 1;
        else
            hi = middle;
    }
    return 0;
}

/* Has the primitive gone farther from its free motion than its margin? Only then can it touch one
   that it was not thought near. */
static int ecp_i_strayed(const ecp_i_step *s, int i)
{
    const ecp_i_part *p = ecp_i_parts(s->w) + i;
    const ecp_i_motion *m = s->motions + p->body;
    ecp_real off[3];
    if (!m->dynamic) return 0;
    ecp_i_sub(m->dv, m->free, off);
    return s->h * (ecp_i_norm(off) + s->reaches[i] * ecp_i_norm(m->v + 3)) > s->margins[i];
}

/* Adds a pair to the extra ones. One more than there may be patches is enough for ecp_i_find_pairs to see that they are
   too many. */
static void ecp_i_add_extra(ecp_i_step *s, int i, int j)
{
    if (s->extras > s->w->desc.max_patches) return;
    s->extra[2 * s->extras] = i;
    s->extra[2 * s->extras++ + 1] = j;
}

/* adds the corners that were left out but overlap at the end of the step */
static void ecp_i_find_corners(ecp_i_step *s)
{
    size_t mark = s->arena.used;
    ecp_i_pair *c;
    int k;
    if (s->corners == 0) return;
    c = (ecp_i_pair *)ecp_i_take(&s->arena, 1, sizeof(ecp_i_pair));
    ECPSIM_ASSERT(c);
    for (k = 0; k < s->corners; k++) {
        const ecp_i_corner *corner = s->corner + k;
        if (ecp_i_pair_bind(s, corner->i, corner->j, c) && ecp_i_touching(s, c, corner->n))
            ecp_i_add_extra(s, corner->i, corner->j);
    }
    ecp_i_release(&s->arena, mark, s->arena.top);
}

/* adds all pairs that were left out but overlap at the end of the step to the extra ones */
static void ecp_i_find_touching(ecp_i_step *s)
{
    const ecp_i_part *parts = ecp_i_parts(s->w);
    ecp_i_broad *b = &s->broad;
    ecp_i_pair *c;
    size_t mark = s->arena.used;
    int i, j, k, found, strayed = 0, shapes = s->w->shapes;
    for (i = 0; i < shapes && !strayed; i++) {
        if (parts[i].body == ECP_I_FREE) continue;
        strayed = ecp_i_strayed(s, i);
    }
    if (ECP_I_PAIRS) ecp_i_find_corners(s);
    if (!strayed) return;
    for (i = 0; ECP_I_PAIRS && i < shapes; i++) {
        if (parts[i].body == ECP_I_FREE) continue;
        ecp_i_part_box(parts + i, s->motions + parts[i].body, 1, 0, b->boxes + i);
    }
    if (ECP_I_PAIRS) ecp_i_broad_build(b, parts, shapes);
    c = (ecp_i_pair *)ecp_i_take(&s->arena, 1, sizeof(ecp_i_pair));
    ECPSIM_ASSERT(c);
    for (i = 0; i < shapes; i++) {
        if (parts[i].body == ECP_I_FREE || parts[i].shape.kind == ECP_HALF_SPACE) continue;
        if (!ecp_i_strayed(s, i)) continue;
        found = ecp_i_candidates(b, parts, shapes, i, -1);
        for (k = 0; k < found; k++) {
            int lo = i < b->hits[k] ? i : b->hits[k];
            j = i + b->hits[k] - lo;
            /* (with pairs the other one may have strayed, too, and have been there before) */
            if (ecp_i_is_in(s, lo, j) || (ECP_I_PAIRS && ecp_i_is_extra(s, lo, j))) continue;
            if (ecp_i_pair_bind(s, lo, j, c) && ecp_i_touching(s, c, NULL))
                ecp_i_add_extra(s, lo, j);
        }
    }
    ecp_i_release(&s->arena, mark, s->arena.top);
}

/* pairs of primitives that could make a patch if they were near each other, without filters; INT_MAX if there are
   more */
static int ecp_i_count_pairs(const ecp_i_step *s)
{
    const ecp_i_part *parts = ecp_i_parts(s->w);
    int i, all = 0, dynamic = 0, pairs = 0, more;
    /* (of one body alone it is zero) */
    for (i = 0; ECP_I_PAIRS && i < s->w->bodies; i++) s->motions[i].at = 0;
    for (i = 0; i < s->w->shapes; i++) {
        ecp_i_motion *m;
        if (parts[i].body == ECP_I_FREE) continue;
        m = s->motions + parts[i].body;
        /* with those before it */
        more = m->dynamic ? all - m->at++ : dynamic;
        if (more > 0x7fffffff - pairs) return 0x7fffffff;
        pairs += more;
        dynamic += m->dynamic;
        all++;
    }
    return pairs;
}

/* the body that stands for the set that body i is in; the lowest index of the set */
static int ecp_i_island_root(ecp_i_motion *motions, int i)
{
    while (ECP_I_PAIRS && motions[i].island != i) {
        motions[i].island = motions[motions[i].island].island;
        i = motions[i].island;
    }
    return i;
}

/* Joins bodies that share patches, and lists the bodies and patches of each island, in their order,
   at its first body. */
static void ecp_i_label_islands(ecp_i_step *s)
{
    ecp_i_motion *motions = s->motions;
    int i, a, b;
    for (i = 0; i < s->w->bodies; i++) {
        motions[i].island = motions[i].dynamic ? i : -1;
        motions[i].first_pair = motions[i].next_body = -1;
    }
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        if (!ecp_i_moves_a(c) || !ecp_i_moves_b(c)) continue;
        a = ecp_i_island_root(motions, c->a->body);
        b = ecp_i_island_root(motions, c->b->body);
        if (a < b)
            motions[b].island = a;
        else
            motions[a].island = b;
    }
    for (i = s->w->bodies - 1; ECP_I_PAIRS && i >= 0; i--) {
        if (!motions[i].dynamic) continue;
        a = ecp_i_island_root(motions, i);
        motions[i].island = a;
        if (a == i) continue;
        motions[i].next_body = motions[a].next_body;
        motions[a].next_body = i;
    }
    for (i = s->pair_count - 1; i >= 0; i--) {
        ecp_i_pair *c = s->pairs + i;
        ecp_i_motion *m = motions + (ecp_i_moves_a(c) ? c->ma : c->mb)->island;
        c->next_pair = m->first_pair;
        m->first_pair = i;
    }
}

/* >>sleep: islands that repeat their last step, bit for bit, are left out

   A step is a function of the state and of what it is asked for. An island that has come out of a
   step as it went in, bodies and patches, with its bodies at rest, comes out of the next one in the
   same way: if that is asked for the same, if nobody has touched a body of it, and if the patches
   that the step begins with are the last one's. So the flags are set by comparing bytes, calls that
   change anything clear them, and who comes near is found in the usual way, as a new patch. */

static void ecp_i_ask(const ecp_options *o, ecp_i_asked *asked)
{
    asked->tolerance = o->tolerance;
    asked->sleep = 1;
    asked->rule = (int)o->rule;
    asked->max_iterations = o->max_iterations;
    asked->max_total_iterations = o->max_total_iterations;
    asked->fallbacks = o->fallbacks;
}

static int ecp_i_same_asked(const ecp_i_asked *a, const ecp_i_asked *b)
{
    return a->tolerance == b->tolerance && a->sleep == b->sleep && a->rule == b->rule &&
           a->max_iterations == b->max_iterations &&
           a->max_total_iterations == b->max_total_iterations && a->fallbacks == b->fallbacks;
}

/* who is to fall asleep, and whose flags hold for this step; sub-steps know no sleep */
static void ecp_i_begin_sleep(ecp_i_step *s, int substep)
{
    ecp_i_asked asked;
    if (ECP_I_SLEEP) s->is_watched = s->o->sleep && !substep;
    if (!ecp_i_watched(s)) return;
    ecp_i_ask(s->o, &asked);
    s->has_sleepers = ecp_i_same_asked(&asked, &s->w->asked) && s->h == s->w->last_h;
}

static void ecp_i_stir(ecp_i_step *s, const ecp_i_patch *p)
{
    const ecp_i_part *parts = ecp_i_parts(s->w);
    s->motions[parts[p->contact.shape_a].body].stirred = 1;
    s->motions[parts[p->contact.shape_b].body].stirred = 1;
}

/* marks the bodies with a patch that the last step has not left, or that this one has not taken */
static void ecp_i_mark_stirred(ecp_i_step *s)
{
    const ecp_i_patch *list = ecp_i_patches(s->w);
    int i, next = 0;
    s->r->asleep = 0;
    if (!ecp_i_watched(s)) return;
    for (i = 0; i < s->w->bodies; i++) s->motions[i].asleep = s->motions[i].stirred = 0;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        if (c->old < 0) {
            /* of two that are left out of the equations nothing is kept (ecp_i_end_sleep) */
            if (ecp_i_on_plane(c)) c->ma->stirred = c->mb->stirred = 1;
            continue;
        }
        while (next < c->old) ecp_i_stir(s, list + next++);
        next++;
    }
    while (next < s->w->patches) ecp_i_stir(s, list + next++);
}

/* does the island sleep, and is what it lies on as it was? */
static int ecp_i_island_sleeps(const ecp_i_step *s, int label)
{
    int i;
    if (!ecp_i_sleepers(s)) return 0;
    for (i = label; i >= 0; i = s->motions[i].next_body) {
        if (!s->motions[i].quiet || s->motions[i].stirred) return 0;
    }
    for (i = s->motions[label].first_pair; i >= 0; i = s->pairs[i].next_pair) {
        if (!s->pairs[i].ma->quiet || !s->pairs[i].mb->quiet) return 0;
    }
    return 1;
}

/* an island that sleeps: its bodies stay, and so do its patches */
static void ecp_i_keep_island(ecp_i_step *s, int label)
{
    static const ecp_real none[6] = {0, 0, 0, 0, 0, 0};
    size_t reals = (size_t)s->w->desc.max_inequalities;
    int i;
    for (i = label; i >= 0; i = s->motions[i].next_body) {
        s->motions[i].asleep = 1;
        ecp_i_move(s->motions + i, s->h, none);
        s->r->asleep++;
    }
    ecp_i_carve_records(s, label);
    for (i = s->motions[label].first_pair; i >= 0; i = s->pairs[i].next_pair) {
        ecp_i_pair *c = s->pairs + i;
        if (ECP_I_PAIRS && c->old < 0) {
            c->on_b->set = ECP_I_OUT;
            s->without++;
            continue;
        }
        ECPSIM_MEMCPY(c->record, ecp_i_patches(s->w) + c->old, sizeof(ecp_i_patch));
        ECPSIM_MEMCPY(c->multipliers, ecp_i_multipliers(s->w, c->old), reals * sizeof(ecp_real));
        s->r->centred &= c->record->centred > 0;
    }
}

/* at rest, and after the step as before it? */
static int ecp_i_is_still(const ecp_i_body *before, const ecp_i_body *b)
{
    int k;
    for (k = 0; k < 6; k++) {
        if (!(b->v[k] == 0 && b->v_carry[k] == 0)) return 0;
    }
    return ecp_i_same_bytes(before, b, offsetof(ecp_i_body, kind));
}

/* The pair was left out of the step though it touches: if the two sleep, it is looked at all the same. */
static void ecp_i_sleeps_lightly(const ecp_i_step *s, int shape_a, int shape_b)
{
    ecp_i_body *a = ecp_i_bodies(s->w) + ecp_i_parts(s->w)[shape_a].body;
    ecp_i_body *b = ecp_i_bodies(s->w) + ecp_i_parts(s->w)[shape_b].body;
    if (a->asleep) a->asleep = 2;
    if (b->asleep) b->asleep = 2;
}

/* Flags what a step has left as it was: first each body by itself (ecp_i_commit), then islands. The
   world's list of patches is still the old one. */
static void ecp_i_end_sleep(ecp_i_step *s)
{
    ecp_i_body *bodies = ecp_i_bodies(s->w);
    size_t reals = (size_t)s->w->desc.max_inequalities;
    int i;
    if (ECP_I_SLEEP) ECPSIM_MEMSET(&s->w->asked, 0, sizeof s->w->asked);
    if (!ecp_i_watched(s)) return;
    ecp_i_ask(s->o, &s->w->asked);
    for (i = 0; i < s->w->bodies; i++) {
        ecp_i_motion *m = s->motions + i;
        if (!m->dynamic) continue;
        s->motions[m->island].stirred |= m->stirred || !bodies[i].asleep;
    }
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        ecp_i_motion *root = s->motions + (ecp_i_moves_a(c) ? c->ma : c->mb)->island;
        if (root->asleep || root->stirred) continue;
        if (ecp_i_left_out(c) || c->old < 0) {
            root->stirred = !ecp_i_left_out(c) || c->old >= 0;
            continue;
        }
        root->stirred =
            !ecp_i_same_bytes(c->record, ecp_i_patches(s->w) + c->old, sizeof(ecp_i_patch)) ||
            !ecp_i_same_bytes(c->multipliers, ecp_i_multipliers(s->w, c->old),
                              reals * sizeof(ecp_real));
    }
    for (i = 0; i < s->w->bodies; i++) {
        const ecp_i_motion *m = s->motions + i;
        if (m->dynamic && s->motions[m->island].stirred) bodies[i].asleep = 0;
    }
    for (i = 0; ECP_I_PAIRS && i < s->corners; i++)
        ecp_i_sleeps_lightly(s, s->corner[i].i, s->corner[i].j);
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        if (ecp_i_left_out(c)) ecp_i_sleeps_lightly(s, c->shape_a, c->shape_b);
    }
}

/* Do all bodies sleep? Then the step is done, but for its report. */
static int ecp_i_world_sleeps(ecp_i_step *s)
{
    const ecp_i_body *bodies = ecp_i_bodies(s->w);
    int i;
    if (!ecp_i_sleepers(s)) return 0;
    for (i = 0; i < s->w->bodies; i++) {
        if (bodies[i].kind != ECP_I_FREE && !bodies[i].asleep) return 0;
    }
    for (i = 0; i < s->w->bodies; i++) {
        s->motions[i].dynamic = bodies[i].kind == ECP_DYNAMIC;
        s->r->asleep += s->motions[i].dynamic;
    }
    s->r->centred = s->o->rule == ECP_CENTRED;
    for (i = 0; i < s->w->patches; i++) {
        const ecp_i_patch *p = ecp_i_patches(s->w) + i;
        ecp_real gap = p->contact.separation;
        if (i == 0 || gap < s->r->worst_gap) s->r->worst_gap = gap;
        s->r->centred &= p->centred > 0;
    }
    s->pair_count = s->w->patches;
    return 1;
}

/* >>solve: one island */

/* what the points of a body move by its turn w, on the average that counts in its energy: as much as
   `length` |w| if its three moments of inertia are equal */
static ecp_real ecp_i_spin_speed(const ecp_i_motion *m, const ecp_real w[3])
{
    ecp_real L[3];
    if (ECP_I_FAST && ecp_i_is_zero(w)) return 0;
    ecp_i_mul(m->inertia, w, L);
    return ecp_i_sqrt(ecp_i_max(3 * ecp_i_dot(w, L) / m->mass, 0));
}

/* the most that a point of a part moves by the turn w of its body */
static ecp_real ecp_i_sweep_speed(const ecp_i_part *part, const ecp_i_motion *m,
                                  const ecp_real w[3])
{
    ecp_real own[3], r[3], u[3];
    int k;
    if (ECP_I_FAST && ecp_i_is_zero(w)) return 0;
    ecp_i_mul_t(m->R0, w, own);
    for (k = 0; k < 3; k++) {
        own[k] = ecp_i_abs(own[k]);
        r[k] = ecp_i_abs(part->box_centre[k]) + part->box_half[k];
    }
    ecp_i_set3(own[1] * r[2] + own[2] * r[1], own[2] * r[0] + own[0] * r[2],
               own[0] * r[1] + own[1] * r[0], u);
    return ecp_i_norm(u);
}

/* vs: the fastest free motion, what closes an overlap in one step, or g h; never below what moves a body
   by 64 rounding units of its size, where nothing could be told from noise. How fast a turn is, is what
   it moves: a needle may spin about itself at 1e4 rad/s, and its other velocities count all the same.
   On the way n of the patches becomes the normal at the beginning of the step (ecp_i_bears). */
static ecp_real ecp_i_island_speed(const ecp_i_island *s)
{
    ecp_real speed = s->h * ecp_i_norm(s->world->desc.gravity);
    int i, k;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        const ecp_i_motion *m = ecp_i_mover(s, i);
        ecp_i_raise(&speed, 64 * ECP_I_EPSILON * m->length / s->h);
        for (k = 0; k < 2; k++) {
            const ecp_real *v = k ? m->body->v : m->v;
            ecp_i_raise(&speed, ecp_i_norm(v));
            ecp_i_raise(&speed, ecp_i_spin_speed(m, v + 3));
        }
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        const ecp_i_motion *other = ecp_i_moves_b(c) ? c->ma : c->mb;
        const ecp_i_patch *old = c->old < 0 ? NULL : ecp_i_patches(s->world) + c->old;
        if (!other->dynamic) ecp_i_raise(&speed, ecp_i_norm(other->v));
        for (k = 0; k < (ecp_i_on_plane(c) ? 2 : 4); k++) {
            const ecp_i_motion *m = k < 2 ? c->ma : c->mb;
            const ecp_real *v = k % 2 ? m->body->v : m->v;
            ecp_i_raise(&speed, ecp_i_sweep_speed(k < 2 ? c->a : c->b, m, v + 3));
        }
        ecp_i_raise(&speed, ecp_i_depth(c, old, c->n) / s->h);
    }
    return ecp_i_power_of_two(speed);
}

/* Which of a patch's bodies is carried: the upper one, or without gravity the lighter one. */
static ecp_i_motion *ecp_i_carried(const ecp_i_island *s, const ecp_i_pair *c)
{
    const ecp_real *g = s->world->desc.gravity;
    ecp_real down = ecp_i_dot(g, c->offset);
    if (!ecp_i_moves_a(c) || !ecp_i_moves_b(c)) return ecp_i_moves_a(c) ? c->ma : c->mb;
    if (!(ecp_i_norm(g) > 0)) down = c->ma->mass - c->mb->mass;
    if (down == 0) return c->ma < c->mb ? c->ma : c->mb;
    return down > 0 ? c->mb : c->ma;
}

/* how far gravity points along the normal out of the carried body, at the beginning of the step */
static ecp_real ecp_i_upright(const ecp_i_island *s, const ecp_i_pair *c)
{
    ecp_real down = ecp_i_dot(s->world->desc.gravity, c->n);
    return c->carried == c->ma ? down : -down;
}

/* Does a patch take a share of the load to start with? Not that of a pair if another patch carries the body more
   from below: where boxes stand flush, edges and corners touch as well as faces. */
static int ecp_i_bears(const ecp_i_island *s, const ecp_i_pair *c)
{
    const ecp_i_pair *other = c->carried->rests_on;
    ecp_real own = ecp_i_upright(s, c);
    if (ecp_i_on_plane(c)) return 1;
    for (; other; other = other->next_below) {
        ecp_real best = ecp_i_upright(s, other);
        if (best > 0 && own < ECP_R(0.9) * best) return 0;
    }
    return 1;
}

/* The mass that rests on each patch: a body's own and what it carries, shared alike by those of the patches
   that carry it that bear; handed down from the bodies that carry nothing. */
static void ecp_i_island_loads(ecp_i_island *s)
{
    ecp_i_motion *ready = NULL;
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        m->load = m->mass;
        m->loads = m->carries = 0;
        m->rests_on = NULL;
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_i_motion *carried = c->carried = ecp_i_carried(s, c);
        if (!ECP_I_PAIRS) {
            carried->loads++;
            continue;
        }
        c->next_below = carried->rests_on;
        carried->rests_on = c;
        (carried == c->ma ? c->mb : c->ma)->carries++;
    }
    for (i = 0; ECP_I_PAIRS && i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        int bears = ecp_i_bears(s, c);
        if (!ecp_i_on_plane(c)) c->on_b->bears = bears;
        c->carried->loads += bears;
    }
    for (i = ecp_i_body_count(s) - 1; i >= 0; i--) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        if (!ECP_I_PAIRS || m->carries > 0) continue;
        m->next_ready = ready;
        ready = m;
    }
    while (ready) {
        ecp_i_motion *m = ready;
        const ecp_i_pair *c;
        ready = m->next_ready;
        for (c = m->rests_on; c; c = c->next_below) {
            ecp_i_motion *below = c->ma == m ? c->mb : c->ma;
            if (ecp_i_on_plane(c) || c->on_b->bears) below->load += m->load / (ecp_real)m->loads;
            if (--below->carries > 0 || !below->dynamic) continue;
            below->next_ready = ready;
            ready = below;
        }
    }
}

/* m touches `other`: is that one of the two heaviest? */
static void ecp_i_add_neighbour(ecp_i_motion *m, ecp_i_motion *other)
{
    const ecp_i_motion *heaviest = m->next_ready;
    if (!m->dynamic || !other->dynamic || heaviest == other) return;
    if (heaviest && !(other->mass > heaviest->mass)) {
        ecp_i_raise(&m->load, other->mass);
        return;
    }
    m->load = heaviest ? heaviest->mass : ECP_R(0);
    m->next_ready = other;
}

/* What the two of a patch can be pressed together by: the lighter of them, each with the heaviest of the others that it
   touches. */
static ecp_real ecp_i_mass_between(const ecp_i_pair *c)
{
    ecp_real behind[2];
    int k;
    for (k = 0; k < 2; k++) {
        const ecp_i_motion *m = k ? c->mb : c->ma, *other = k ? c->ma : c->mb;
        behind[k] = m->mass;
        if (m->next_ready) behind[k] += m->next_ready == other ? m->load : m->next_ready->mass;
    }
    return ecp_i_min(behind[0], behind[1]);
}

/* up to so many times the lighter one's mass that mass does as well */
#define ECP_I_AS_HEAVY ECP_R(8)

/* Without gravity a light body that heavy ones push each other with, or are shut up in, passes on what these do: with
   its own mass as the unit loads were of any number of units, and Newton did not find them. */
static void ecp_i_weightless_units(ecp_i_island *s, ecp_real speed)
{
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        m->load = 0;
        m->next_ready = NULL;
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_add_neighbour(s->pairs[i]->ma, s->pairs[i]->mb);
        ecp_i_add_neighbour(s->pairs[i]->mb, s->pairs[i]->ma);
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_real between;
        /* (not against what does not move: most that touch it are not pressed on it by others) */
        if (!ecp_i_moves_a(c) || !ecp_i_moves_b(c)) continue;
        between = ecp_i_mass_between(c);
        if (between > ECP_I_AS_HEAVY * c->carried->mass) c->P = ecp_i_power_of_two(between * speed);
    }
}

/* Units of the unknowns and rows. Impulse: the load times vs. */
static void ecp_i_island_units(ecp_i_island *s)
{
    ecp_real speed = ecp_i_island_speed(s), load;
    int i, k;
    ecp_i_island_loads(s);
    for (i = 0; i < ecp_i_body_count(s); i++) ecp_i_mover(s, i)->speed = speed;
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        c->V = speed;
        c->L = c->carried->length;
        if (ecp_i_moves_a(c) && ecp_i_moves_b(c)) c->L = ecp_i_min(c->ma->length, c->mb->length);
        /* of bodies that touch each other in float multipliers are rounding far above a step's tilt (crates would
           not come to rest), and heaps take no fewer iterations with it */
        c->tilt = ecp_i_body_count(s) > 1 ? ECP_R(1)
                                          : ecp_i_power_of_two(ecp_i_min(1, s->h * speed / c->L));
        load = c->carried->load / (ecp_real)c->carried->loads;
        c->P = ecp_i_power_of_two(load * speed);
        ecp_i_scale(-s->h * load / c->P, s->world->desc.gravity, c->weight);
        c->rho = 1;
        for (k = 0; k < ecp_i_nf(c); k++) {
            ecp_real e = k < 2 ? c->e[k] : c->e[k] / c->L;
            c->rho = ecp_i_max(c->rho, e * e);
        }
        c->rho = 1 / c->rho;
    }
    if (ecp_i_body_count(s) > 1 && !(ecp_i_norm(s->world->desc.gravity) > 0))
        ecp_i_weightless_units(s, speed);
}

/* The largest f_i of a primitive at a point x in its frame; f and g are those of the point. */
static ecp_real ecp_i_most_outside(const ecp_shape *s, const ecp_real x[3], int count, ecp_real *f,
                                   ecp_real *g)
{
    ecp_real most;
    int i;
    s->cls->eval(s, x, f, g);
    most = f[0];
    for (i = 1; i < count; i++) most = ecp_i_max(most, f[i]);
    return most;
}

/* the same of a point seen from where positions are counted */
static ecp_real ecp_i_outside(const ecp_i_posed *p, const ecp_real x[3], int count, ecp_real *f,
                              ecp_real *g)
{
    ecp_real rel[3], local[3];
    ecp_i_sub(x, p->x, rel);
    ecp_i_mul_t(p->Q, rel, local);
    return ecp_i_most_outside(p->shape, local, count, f, g);
}

/* A point `at`, to which what slides away from `before` has gone along the tangent, from A's centre of mass, in the axes
   that A has before its turn w h: put on the arc on which that turn leaves it behind, as far as the plane of the contact
   lets it. */
static void ecp_i_turn_away(const ecp_real w[3], ecp_real h, const ecp_real normal[3],
                            const ecp_real before[3], ecp_real at[3])
{
    ecp_real T[9], J[9], way[3];
    ecp_i_cross(w, before, way);
    ecp_i_axpy(way, -ecp_i_dot(way, normal), normal, way);
    ecp_i_axpy(at, h, way, at);
    ecp_i_cayley(w, -h, T, J);
    ecp_i_mul(T, at, way);
    ecp_i_add(at, way, at);
    ecp_i_sub(at, before, way);
    ecp_i_axpy(at, -ecp_i_dot(way, normal), normal, at);
}

/* A pair's ECP a, in the frame of A, to start from that of the last step. Where one slides on the other it goes with
   the one that moves, with A if both do, unless it would leave the other: the pressure of a box stays under the
   box, on a floor that is a box as well. rests: they stay where they are, not where the trial motion has them. */
static void ecp_i_carry_ecp(const ecp_i_pair *c, const ecp_i_patch *old, ecp_real h, int rests,
                            ecp_real a[3])
{
    ecp_i_posed A, B;
    ecp_real before[3], at[3], r[3], way[3], on_b[3], stays, goes;
    const ecp_contact *k = &old->contact;
    const ecp_real *va = rests ? c->ma->body->v : c->ma->v;
    const ecp_real *vb = rests ? c->mb->body->v : c->mb->v;
    ecp_i_pose(c, 0, 0, &A);
    ecp_i_mul(A.Q, old->a, before);
    ecp_i_add(before, A.x, before);
    /* how far B slides */
    ecp_i_sub(vb, va, way);
    ecp_i_cross(before, va + 3, r);
    ecp_i_add(way, r, way);
    ecp_i_add(before, c->offset, on_b);
    ecp_i_add_cross(vb + 3, on_b, way);
    ecp_i_axpy(way, -ecp_i_dot(way, k->normal), k->normal, way);
    ecp_i_scale(h, way, way);
    /* (less is the rounding of what rests) */
    if (!(ecp_i_norm(way) > 4 * ECP_I_EPSILON * (c->a->shape.radius + c->b->shape.radius))) return;
    /* the poses at the end but for what the two move apart or together */
    ecp_i_pose(c, 1, 0, &B);
    ecp_i_add(B.x, way, B.x);
    ecp_i_axpy(before, -k->gap, k->normal, on_b);
    stays = ecp_i_outside(&B, on_b, c->nm, c->on_b->fb, c->on_b->gb);
    ecp_i_add(before, way, at);
    goes = ecp_i_outside(&A, at, c->nl, c->fa, c->ga);
    if (ecp_i_moves_a(c) ? stays <= ecp_i_slack(c) || 2 * goes >= stays
                         : goes > ecp_i_slack(c) && 2 * goes >= stays)
        return;
    /* (of a kinematic one: for what is free to turn it led to nothing, and heaps took more iterations) */
    if (!ecp_i_moves_a(c) && ecp_i_largest(3, va + 3) > 0)
        ecp_i_turn_away(va + 3, h, k->normal, before, at);
    ecp_i_sub(at, A.x, at);
    ecp_i_mul_t(A.Q, at, a);
}

/* The ECP a of a flat face on a half-space, in the frame of A, which turns about the normal: the pressure stays where it
   is, and A turns under it. Not on an edge or a corner, which turn with A, nor on a curve, which rolls
   (ecp_i_roll_ecp). (fa and ga are taken for room.) */
static void ecp_i_turn_ecp_back(const ecp_i_pair *c, const ecp_real normal[3], ecp_real h,
                                const ecp_real *multipliers, ecp_real a[3])
{
    const ecp_real tiny = ecp_i_sqrt(ECP_I_EPSILON), *centre = c->a->shape.centre;
    ecp_real rate = ecp_i_dot(normal, c->ma->body->v + 3) - ecp_i_dot(normal, c->mb->body->v + 3);
    ecp_real Q[9], n[3], w[3], T[9], J[9], from[3], at[3], off[3];
    int i, face = 0, faces = 0;
    if (!(ecp_i_abs(h * rate) > tiny)) return;
    for (i = 0; i < c->nl; i++) {
        if (!(multipliers[i] > tiny)) continue;
        face = i;
        faces++;
    }
    if (faces != 1) return;
    ecp_i_matmul(c->ma->R0, c->a->rotation, Q);
    ecp_i_mul_t(Q, normal, n);
    ecp_i_scale(rate, n, w);
    ecp_i_cayley(w, -h, T, J);
    ecp_i_sub(a, centre, from);
    ecp_i_mul(T, from, at);
    ecp_i_add(at, a, at);
    c->a->shape.cls->eval(&c->a->shape, at, c->fa, c->ga);
    ecp_i_add(c->ga + 3 * face, n, off);
    if (ecp_i_largest(3, off) > tiny) return;
    for (i = 0; i < c->nl; i++) {
        if (c->fa[i] > tiny * c->a->shape.radius) return;
    }
    ecp_i_copy3(at, a);
}

/* Is a primitive flat at the point x of it, where it has these multipliers, so that the normal turns with it? Then N is
   the normal of its face; f and g, of its constraints, are room. */
static int ecp_i_flat_at(const ecp_i_part *part, int count, const ecp_real *l, const ecp_real x[3],
                         ecp_real *f, ecp_real *g, ecp_real N[3])
{
    const ecp_shape *s = &part->shape;
    const ecp_real tiny = ecp_i_sqrt(ECP_I_EPSILON);
    ecp_real H[9];
    int i, face = 0, active = 0;
    for (i = 0; i < count; i++) {
        if (!(l[i] > tiny)) continue;
        face = i;
        active++;
    }
    if (active != 1) return 0;
    if (s->cls->hess) {
        s->cls->hess(s, x, l, H);
        if (s->radius * ecp_i_largest(9, H) > tiny) return 0;
    }
    s->cls->eval(s, x, f, g);
    ecp_i_mul(part->rotation, g + 3 * face, N);
    return ecp_i_normalise(N);
}

/* The sine of the angle up to which what rolls lies on a generator or a face. Above the rounding of normals in float:
   below it support points jump between the ends of the generator. */
#define ECP_I_GENERATOR ECP_R(1e-3)

/* A point x of a primitive whose normal there, in the primitive's frame, turns from n0 to n1: it moves as the support
   point does, and so stays where it is along a generator. f and g are those of the new point. 0, with x as it was, if
   nothing moves or the normal turns by rounding, if the new point is not of the surface, or if it is another end of a
   generator (by more than a curve of four times the primitive's radius would move it). */
static int ecp_i_roll_point(const ecp_shape *s, int count, const ecp_real n0[3],
                            const ecp_real n1[3], ecp_real *f, ecp_real *g, ecp_real x[3])
{
    ecp_real turn[3], to[3], way, angle;
    s->cls->support(s, n0, ECP_I_GENERATOR, turn);
    s->cls->support(s, n1, ECP_I_GENERATOR, to);
    ecp_i_sub(to, turn, to);
    ecp_i_sub(n1, n0, turn);
    way = ecp_i_norm(to);
    angle = ecp_i_norm(turn);
    if (!(way > 0 && angle > 4 * ECP_I_EPSILON) || way > 4 * s->radius * angle) return 0;
    ecp_i_add(x, to, to);
    way = ecp_i_abs(ecp_i_most_outside(s, to, count, f, g));
    if (way > ecp_i_sqrt(ECP_I_EPSILON) * s->radius) return 0;
    ecp_i_copy3(to, x);
    return 1;
}

/* the point x of one primitive, moved by `by` along the world direction n, in the frame of another */
static void ecp_i_across(const ecp_i_posed *from, const ecp_real x[3], ecp_real by,
                         const ecp_real n[3], const ecp_i_posed *to, ecp_real out[3])
{
    ecp_real at[3];
    ecp_i_mul(from->Q, x, at);
    ecp_i_add(at, from->x, at);
    ecp_i_axpy(at, by, n, at);
    ecp_i_sub(at, to->x, at);
    ecp_i_mul_t(to->Q, at, out);
}

/* What is curved rolls on what is flat: the normal is that of the flat side, and the ECP is where the curved one has it
   at the end of the trial motion. In y, which has the ECP (frame of A, in metres) and the multipliers of the last step,
   the ECP and the multipliers of the curved side; 0, with y as it was, if it is not so. */
static int ecp_i_roll_ecp(const ecp_i_pair *c, const ecp_i_patch *old, const ecp_real *multipliers,
                          ecp_real *y)
{
    const ecp_contact *k = &old->contact;
    const ecp_i_motion *flat = c->mb, *curved = c->ma;
    const ecp_i_part *part = c->a;
    ecp_i_posed A, B;
    ecp_real x[3], N[3], n0[3], n1[3], at[3], slack = ecp_i_slack(c), *f = c->fa, *g = c->ga;
    int rolls_b = 0, count = c->nl;
    if (!c->a->shape.cls->hess && (ecp_i_on_plane(c) || !c->b->shape.cls->hess)) return 0;
    if (ecp_i_on_plane(c)) {
        ecp_i_mul_t(flat->R0, k->normal, n1);
    } else {
        ecp_i_poses(c, 0, &A, &B);
        ecp_i_across(&A, y, -k->gap, k->normal, &B, at);
        if (!ecp_i_flat_at(c->b, c->nm, multipliers + c->nl, at, c->on_b->fb, c->on_b->gb, n1)) {
            if (!ecp_i_flat_at(c->a, c->nl, multipliers, y, c->fa, c->ga, n1)) return 0;
            ecp_i_scale(-1, n1, n1);
            flat = c->ma, curved = c->mb;
            part = c->b;
            f = c->on_b->fb, g = c->on_b->gb;
            count = c->nm;
            rolls_b = 1;
        }
    }
    /* (the normal of the last step may be off by what its solution was: that would grow from step to step) */
    ecp_i_mul(flat->R, n1, N);
    ecp_i_mul_t(curved->R0, k->normal, n1);
    ecp_i_mul_t(part->rotation, n1, n0);
    ecp_i_mul_t(curved->R, N, x);
    ecp_i_mul_t(part->rotation, x, n1);
    ecp_i_copy3(rolls_b ? at : y, x);
    if (!rolls_b) {
        ecp_i_scale(-1, n0, n0);
        ecp_i_scale(-1, n1, n1);
    }
    if (!ecp_i_roll_point(&part->shape, count, n0, n1, f, g, x)) return 0;
    if (!ecp_i_on_plane(c)) {
        ecp_i_poses(c, 1, &A, &B);
        if (rolls_b) {
            ecp_i_across(&B, x, k->gap, N, &A, at);
            if (ecp_i_most_outside(&c->a->shape, at, c->nl, c->fa, c->ga) > slack) return 0;
        } else {
            ecp_i_across(&A, x, -k->gap, N, &B, at);
            if (ecp_i_most_outside(&c->b->shape, at, c->nm, c->on_b->fb, c->on_b->gb) > slack)
                return 0;
        }
    }
    ecp_i_cone_multipliers(count, f, g, n1, ECP_R(1e-3) * part->shape.radius,
                           y + (rolls_b ? ecp_i_at_m(c) : 3));
    ecp_i_copy3(rolls_b ? at : x, y);
    return 1;
}

/* the geometry of the last step's solution, in this step's units, moved on; impulses zero */
static void ecp_i_start_warm(const ecp_i_island *s, const ecp_i_pair *c, ecp_real *y)
{
    const ecp_i_patch *old = ecp_i_patches(s->world) + c->old;
    const ecp_contact *contact = &old->contact;
    const ecp_real *multipliers = ecp_i_multipliers(s->world, c->old);
    int i;
    ecp_i_copy3(old->a, y);
    ecp_i_copy(c->nl, multipliers, y + 3);
    if (!ecp_i_on_plane(c)) {
        ecp_i_copy(c->nm, multipliers + c->nl, y + ecp_i_at_m(c));
        y[ecp_i_at_d(c)] = contact->gap / (s->h * c->V);
    }
    if (s->rests || !ecp_i_roll_ecp(c, old, multipliers, y)) {
        if (ECP_I_FRICTION && ecp_i_on_plane(c))
            ecp_i_turn_ecp_back(c, contact->normal, s->h, multipliers, y);
        if (!ecp_i_on_plane(c)) ecp_i_carry_ecp(c, old, s->h, s->rests, y);
    }
    ecp_i_scale(1 / c->L, y, y);
    for (i = 0; i <= ecp_i_nf(c); i++) y[ecp_i_at_p(c) + i] = 0;
}

/* the impulses of the last step, from its tangents to this step's, which must be known */
static void ecp_i_start_impulses(const ecp_i_island *s, const ecp_i_pair *c, ecp_real *y)
{
    const ecp_contact *old = &ecp_i_patches(s->world)[c->old].contact;
    ecp_real *p = y + ecp_i_at_p(c), tangential[3], P = c->P * (s->world->last_h / s->h);
    p[0] = old->p_n / P;
    if (ecp_i_nf(c) == 0) return;
    /* (tangents are not quite of unit length: what rests would creep by that) */
    if (ecp_i_equal(c->t, old->direction_t) && ecp_i_equal(c->o, old->direction_o)) {
        p[1] = old->p_t / (c->e[0] * P);
        p[2] = old->p_o / (c->e[1] * P);
    } else {
        ecp_i_scale(old->p_t, old->direction_t, tangential);
        ecp_i_axpy(tangential, old->p_o, old->direction_o, tangential);
        p[1] = ecp_i_dot(c->t, tangential) / (c->e[0] * P);
        p[2] = ecp_i_dot(c->o, tangential) / (c->e[1] * P);
    }
    if (ecp_i_nf(c) == 3) p[3] = old->p_r / (c->e[2] * P);
}

/* A point of A's surface beside the one that a geometric start would take: where the normal, tilted
   by a tenth to one of four sides, has its support point. */
static void ecp_i_aside(const ecp_i_pair *c, int k, ecp_real a[3])
{
    ecp_real n[3], side[3], local[3];
    ecp_i_copy3(k & 2 ? c->t : c->o, side);
    ecp_i_axpy(c->n, k & 1 ? ECP_R(0.1) : ECP_R(-0.1), side, n);
    ecp_i_normalise(n);
    ecp_i_mul_t(c->Qa, n, local);
    c->a->shape.cls->support(&c->a->shape, local, 0, a);
}

/* Does a pair whose contact had no load meet in the predicted motion? Then its normal need not be the one that it
   had before. */
static int ecp_i_turns_up(const ecp_i_pair *c, const ecp_i_patch *old)
{
    ecp_i_posed A, B;
    ecp_real n[3];
    if (ecp_i_on_plane(c) || old->contact.p_n > 0) return 0;
    ecp_i_poses(c, 1, &A, &B);
    ecp_i_scale(-1, old->contact.normal, n);
    return ecp_i_separation(&A, &B, n) < -ecp_i_slack(c);
}

/* the last of the starts; fallbacks that a program does without need none but the warm one */
#define ECP_I_STARTS (ECP_I_RESTARTS ? 10 : 0)

/* Where bodies come to rest a gap that the certificate lets pass counts as closed, if it is an overlap or has a load:
   to close it would move what rests. */
static void ecp_i_let_gap_be(const ecp_i_island *s, const ecp_i_pair *c, const ecp_real *y)
{
    ecp_real gap;
    if (ecp_i_on_plane(c)) return;
    gap = s->h * c->V * y[ecp_i_at_d(c)];
    c->on_b->rest = 0;
    if (!s->rests || ecp_i_abs(gap) > ecp_i_let_pass(c, s->tolerance)) return;
    if (gap < 0 || y[ecp_i_at_p(c)] > 0) c->on_b->rest = gap;
}

/* the unknowns of a patch in start k, its impulse on the bodies, and what that may be off; bare: without the impulses
   of the last step */
static void ecp_i_start_patch(ecp_i_island *s, ecp_i_pair *c, int k, int first, int bare,
                              ecp_real *z)
{
    static const ecp_real none[3] = {0, 0, 0};
    const ecp_i_patch *old = c->old < 0 ? NULL : ecp_i_patches(s->world) + c->old;
    int warm = first && old && !old->guess && !ecp_i_turns_up(c, old);
    ecp_real aside[3];
    if (ECP_I_CENTRING && first && old) {
        s->uncentred |= old->centred == 0;
        s->in_vain |= old->centred < 0;
    }
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_CONTINUATION) c->relax = 0;
    c->placed = 0; /* (starts take fa and ga for room) */
    if (warm)
        ecp_i_start_warm(s, c, z + c->at);
    else
        ecp_i_start_geometric(
            c, s->h, old && (first ? old->guess || ecp_i_on_plane(c) : s->nearest) ? old->a : NULL,
            ECP_I_FLAT, first, z + c->at);
    ecp_i_pair_geometry(c, z + c->at);
    if (!ecp_i_on_plane(c)) ecp_i_tangents(c);
    if (k > 6 && !first) {
        ecp_i_aside(c, k, aside);
        ecp_i_start_geometric(c, s->h, aside, ECP_I_FLAT, 0, z + c->at);
        ecp_i_pair_geometry(c, z + c->at);
        ecp_i_tangents(c);
    }
    if (warm && !bare) ecp_i_start_impulses(s, c, z + c->at);
    ecp_i_let_gap_be(s, c, z + c->at);
    ecp_i_pair_impulse(c, z + c->at);
    ecp_i_pair_noise(c, s->h, 2 * s->noise);
    if (ecp_i_moves_a(c)) ecp_i_wrench(c, c->ma, warm ? c->ra : none, 1);
    /* what rests does not fall as the trial motion of a start does: g h^2 off, what friction and walls hold was never in
       balance, and what lies in a box did not come to rest */
    if (warm && s->rests && !ecp_i_on_plane(c)) ecp_i_add(c->offset, c->ra, c->rb);
    if (ecp_i_moves_b(c)) ecp_i_wrench(c, c->mb, warm ? c->rb : none, -1);
}

/* the velocity change with the impulses that m->residual lacks */
static void ecp_i_balance(const ecp_i_motion *m, ecp_real dv[6])
{
    int k;
    ecp_i_velocity_change(m, m->residual, dv);
    for (k = 0; k < 6; k++) dv[k] = m->free[k] - dv[k];
}

/* Contacts win no energy. A warm start in which bodies have so many times what their free motion may have holds the
   impulses of loads that are gone since the last step: gravity, or a force that pressed bodies together. */
#define ECP_I_TOO_FAST ECP_R(1e6)

/* The change of velocities dv without those velocities that are nothing but the rounding of a balance, or of a turn
   that the quaternion has no room for, with the way of the body's outside in it, or that gaps let pass which are off by
   so much: they are zero instead, or they would add up to a drift, or come and go in turn with the impulse that takes
   them back. Is nothing left that moves? */
static int ecp_i_drop_noise(const ecp_i_island *s, const ecp_i_motion *m, ecp_real gaps,
                            ecp_real dv[6])
{
    int j, still = 1;
    for (j = 0; j < 6; j++) {
        ecp_real noise = ecp_i_max(s->noise * m->speed + ecp_i_noise_share(m, j) * gaps,
                                   s->turn / s->h * m->length);
        if (j >= 3) noise /= m->length;
        if (ecp_i_abs(m->body->v[j] + (m->body->v_carry[j] + dv[j])) <= noise)
            dv[j] = -m->body->v[j] - m->body->v_carry[j];
        else
            still = 0;
    }
    return still;
}

/* The velocities that balance the impulses of a warm start, with the rounding floors of its patches. Returns 0 if these
   impulses are of loads that are gone. */
static int ecp_i_balance_start(ecp_i_island *s, ecp_real *z)
{
    ecp_real dv[6], spin[3], excess = 0;
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        ecp_i_balance(m, dv);
        s->still &= ecp_i_drop_noise(s, m, ecp_i_max(m->noise, m->jitter), dv);
        ecp_i_start_motion(m, dv, z + 6 * i);
        ecp_i_mul(m->inertia, dv + 3, spin);
        excess += m->mass * (ecp_i_dot(dv, dv) - ECP_I_TOO_FAST * m->speed * m->speed) +
                  ecp_i_dot(dv + 3, spin);
    }
    return !(excess > 0);
}

/* What the impulses of the last step do to a body may stand for those of this one where with them its velocity changes
   by no more than this part of what it would do without: they hold it, and are not those of an impact. */
#define ECP_I_HELD ECP_R(0.5)

/* What the balances of the bodies lack by the impulses of the last step, where they acted; z is room. How many there
   are. */
static int ecp_i_old_impulses(const ecp_i_island *s, ecp_real *z)
{
    ecp_real r[3];
    int i, loads = 0;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        ECPSIM_MEMSET(m->residual, 0, sizeof m->residual);
    }
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        const ecp_i_patch *old = c->old < 0 ? NULL : ecp_i_patches(s->world) + c->old;
        if (!old || old->guess || !(old->contact.p_n > 0)) continue;
        ecp_i_copy3(old->contact.normal, c->N);
        ecp_i_copy3(old->contact.direction_t, c->t);
        ecp_i_copy3(old->contact.direction_o, c->o);
        c->turns_b = 0; /* (N, t and o are not those of the trial motion) */
        ecp_i_pair_place(c, old->a);
        ecp_i_start_impulses(s, c, z + c->at);
        ecp_i_pair_impulse(c, z + c->at);
        ecp_i_copy3(c->ra0, r);
        if (ecp_i_moves_a(c)) ecp_i_wrench(c, c->ma, r, 1);
        ecp_i_add(c->offset, r, r);
        if (ecp_i_moves_b(c)) ecp_i_wrench(c, c->mb, r, -1);
        loads++;
    }
    return loads;
}

/* Do bodies that move go on as they did on others? Then their balances are what the impulses of the last step make of
   them; z is room. (On half-spaces alone the contacts are found without it.) */
static int ecp_i_moves_on(const ecp_i_island *s, ecp_real *z)
{
    ecp_real dv[6], held = 0, without = 0;
    int i, pairs = 0;
    for (i = 0; i < s->pair_count; i++) pairs += !ecp_i_on_plane(s->pairs[i]);
    if (pairs == 0 || s->rests || ecp_i_old_impulses(s, z) == 0) return 0;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        const ecp_i_motion *m = ecp_i_mover(s, i);
        const ecp_real *free = m->free;
        ecp_real mass = m->mass, inertia = mass * m->length * m->length;
        ecp_i_balance(m, dv);
        held += mass * ecp_i_dot(dv, dv) + inertia * ecp_i_dot(dv + 3, dv + 3);
        without += mass * ecp_i_dot(free, free) + inertia * ecp_i_dot(free + 3, free + 3);
    }
    return held <= ECP_I_HELD * ECP_I_HELD * without;
}

/* All patches and trial motions of a start, which are free but for what moves on; bare: without the impulses of the last
   step. */
static void ecp_i_start_all(ecp_i_island *s, int k, int first, int bare, int moves_on, ecp_real *z)
{
    static const ecp_real parts[4] = {ECP_R(0.5), 0, ECP_R(0.25), ECP_R(0.75)};
    ecp_real dv[6];
    int i, j;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        if (moves_on) {
            ecp_i_balance(m, dv);
            ecp_i_drop_noise(
                s, m, 0,
                dv); /* (tangents would be others by rounding, and impulses turned to them) */
        } else {
            ecp_i_copy(6, m->free, dv);
        }
        for (j = 0; k > 2 && k < 7 && j < 6; j++) {
            dv[j] = parts[k - 3] * (m->body->v[j] + m->free[j]) - m->body->v[j];
        }
        if (!first) ecp_i_start_motion(m, dv, z + 6 * i);
        ECPSIM_MEMSET(m->residual, 0, sizeof m->residual);
        ecp_i_no_noise(m);
        ecp_i_move(m, s->h, dv);
    }
    for (i = 0; i < s->pair_count; i++) ecp_i_start_patch(s, s->pairs[i], k, first, bare, z);
    s->still = first;
}

/* Start k: the patches warm (0), geometric (1), from several points each (2), geometric for the pose that a part of
   the free motion leads to (3 to 6), or geometric with the ECPs to one side (7 to 10). The warm start's velocities
   balance its impulses (a patch without a history knows its load but not where it acts, and gets no moment). Its trial
   motion is that of what moves on: of one body at once, of several, whose impulses change (crates took more
   iterations), in a start of its own, ECP_I_START_MOVES_ON. ECP_I_START_HELD begins at rest, and is that of the several
   points by the associated rule. */
static int ecp_i_island_start(void *self, int k, ecp_real *z)
{
    ecp_i_island *s = (ecp_i_island *)self;
    int together = ECP_I_PAIRS && k == ECP_I_START_MOVES_ON, bare = 0, first, moves_on;
    if (ECP_I_HOLDS && k == ECP_I_START_HELD) {
        ecp_i_start_all(s, ECP_I_START_AT_REST, 0, 0, 0, z);
        return ecp_i_start_spots(s, 1, z);
    }
    if (together) k = 0;
    if (k > ECP_I_STARTS) return 0;
    first = ECP_I_STARTS == 0 || k == 0;
    moves_on =
        ECP_I_PAIRS && first && together == (ecp_i_body_count(s) > 1) && ecp_i_moves_on(s, z);
    if (together && !moves_on) return 0;
    do {
        ecp_i_start_all(s, k, first, bare, moves_on && !bare, z);
        if (k == 2) return ecp_i_start_spots(s, 0, z);
    } while (first && !ecp_i_balance_start(s, z) && !bare++);
    return first && !s->still ? 1 : 2;
}

/* the trial motion of z */
static void ecp_i_island_move(const ecp_i_island *s, const ecp_real *z)
{
    ecp_real dv[6];
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_trial_move(ecp_i_mover(s, i), s->h, z + 6 * i, dv);
    }
}

/* Where Newton has stalled, most often an ECP hangs on to a face or an edge that the pose has turned
   away: new geometry from the support points at the pose of z, with the impulses of z. */
static void ecp_i_island_repair(void *self, ecp_real *z)
{
    ecp_i_island *s = (ecp_i_island *)self;
    ecp_real impulses[4], a[3];
    int i, k;
    ecp_i_island_move(s, z);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_real *p = z + c->at + ecp_i_at_p(c);
        for (k = 0; k <= ecp_i_nf(c); k++) impulses[k] = p[k];
        ecp_i_scale(c->L, z + c->at, a);
        ecp_i_start_geometric(c, s->h, s->nearest ? a : NULL, ECP_I_FLAT, 0, z + c->at);
        for (k = 0; k <= ecp_i_nf(c); k++) p[k] = impulses[k];
    }
}

/* the first pair that has gone through each other, or NULL */
static const ecp_i_pair *ecp_i_passing(const ecp_i_island *s)
{
    int i;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        if (!ecp_i_on_plane(c) && ecp_i_passes(c, c->n) > 0) return c;
    }
    return NULL;
}

/* >>working-set: patches join the equations as they are needed

   What carries nothing holds nothing, but Newton has to find its ECP all the same, and where bodies stand flush that
   is most of the patches, in all their ties: faces against faces, edges on edges. So where it stalls, the equations
   begin with the patches that carried something in the last step. From their solution on, those join that
   overlap in it, the deepest first, and Newton goes on from there. Where it stalls again, fewer join at once; then what
   carries nothing goes; then the one that has joined does, and another one has its turn. What is left out in the end
   is apart, which is shown by a direction. (docs/numerics.md, Working set) */

/* Those join together that are at least this much as deep as the deepest. How often patches may go between two
   solutions; how often Newton is asked in all. */
#define ECP_I_AS_DEEP ECP_R(0.5)
#define ECP_I_GOES 3
#define ECP_I_GATHERINGS 40

/* iterations of Newton from a solution without some patches to one with them, and where they were left out in the last
   step as well */
#define ECP_I_COMPLETING 10
#define ECP_I_COMPLETING_AGAIN 2

/* sorts the patches, those in the equations first, each in its place; the tree is made anew */
static void ecp_i_sort_patches(ecp_i_island *s)
{
    int i, k;
    s->pair_count = 0;
    for (i = 0; i < s->all; i++) {
        ecp_i_pair *c = s->pairs[i];
        int out = ecp_i_left_out(c);
        for (k = i; k > 0; k--) {
            const ecp_i_pair *before = s->pairs[k - 1];
            if (ecp_i_left_out(before) < out ||
                (ecp_i_left_out(before) == out && before->at < c->at))
                break;
            s->pairs[k] = s->pairs[k - 1];
        }
        s->pairs[k] = c;
        s->pair_count += !out;
    }
    if (s->tree.fronts) ecp_i_release(s->arena, s->begin, s->tree.stack);
    s->tree.fronts = NULL;
    s->tree.planned = 0;
}

/* all patches that are in one state go to another one */
static void ecp_i_change_set(const ecp_i_island *s, int from, int to)
{
    int i;
    for (i = 0; i < s->all; i++) {
        ecp_i_pair *c = s->pairs[i];
        if (!ecp_i_on_plane(c) && c->on_b->set == from) c->on_b->set = to;
    }
}

/* what carried nothing in the last step is left out; how many that are */
static int ecp_i_leave_unloaded(const ecp_i_island *s)
{
    int i, count = 0;
    for (i = 0; i < s->all; i++) {
        ecp_i_pair *c = s->pairs[i];
        const ecp_i_patch *old = c->old < 0 ? NULL : ecp_i_patches(s->world) + c->old;
        if (ecp_i_on_plane(c) || (old && !old->guess && old->contact.p_n > 0)) continue;
        c->on_b->set = ECP_I_OUT;
        count++;
    }
    return count;
}

/* What carries nothing at z, where Newton has stalled, goes, but for what has joined since the last solution. How many
   that are. */
static int ecp_i_let_go(const ecp_i_island *s, const ecp_real *z)
{
    int i, count = 0;
    for (i = 0; i < s->all; i++) {
        ecp_i_pair *c = s->pairs[i];
        const ecp_real *y = z + c->at;
        if (ecp_i_on_plane(c) || c->on_b->set != ECP_I_IN) continue;
        if (y[ecp_i_at_p(c)] > y[ecp_i_at_d(c)]) continue;
        c->on_b->set = ECP_I_LET;
        count++;
    }
    return count;
}

/* of the unit of gaps, h V: by so much no two get deeper in each other in a step that have no patch */
#define ECP_I_DEEPER ECP_R(0.125)

/* How deep the two of a patch that is left out are in each other at the trial motion, by more than a certificate lets
   pass, and their radius if they have gone through each other; 0: a direction shows that they are apart. Of two that
   meet in the step less passes: in float, in short steps, a certificate lets more pass than g h^2, and bodies fell freely
   through what they stood on. */
static ecp_real ecp_i_depth_without(ecp_i_pair *c, ecp_real h, ecp_real tolerance)
{
    ecp_i_posed A, B, moved, was[2];
    ecp_real at[2][3], n[3], apart, size = ecp_i_min(c->a->shape.radius, c->b->shape.radius);
    ecp_real limit = ecp_i_let_pass(c, tolerance), deeper = ECP_I_DEEPER * h * c->V;
    ecp_i_poses(c, 0, was, was + 1);
    ecp_i_poses(c, 1, &A, &B);
    moved = B;
    if (!(ecp_i_distance(&A, &B, at[0], at[1], n) > 0))
        ecp_i_move_apart(&A, &moved, at[0], at[1], n);
    if (ecp_i_passes(c, n) > 0) return size;
    apart = ecp_i_separation(&A, &B, n);
    if (ecp_i_separation(was, was + 1, n) - apart > deeper) limit = ecp_i_min(limit, deeper);
    if (apart >= -limit) return 0;
    /* values of f at other points than the patch's own */
    c->placed = 0;
    apart = ecp_i_faces_apart(&A, &B, &moved, at, ECP_R(1e-3) * size, n, 2, apart, c->fa);
    return apart >= -limit ? ECP_R(0) : -apart;
}

/* the depth of all that is left out; and what was done since the last solution is done */
static void ecp_i_find_depths(const ecp_i_island *s, ecp_real tolerance)
{
    int i;
    ecp_i_change_set(s, ECP_I_NEW, ECP_I_IN);
    ecp_i_change_set(s, ECP_I_LET, ECP_I_OUT);
    ecp_i_change_set(s, ECP_I_TRIED, ECP_I_OUT);
    for (i = s->pair_count; i < s->all; i++)
        s->pairs[i]->on_b->depth = ecp_i_depth_without(s->pairs[i], s->h, tolerance);
}

/* a patch joins without a load, at the trial motion */
static void ecp_i_start_new(const ecp_i_island *s, ecp_i_pair *c, ecp_real *z)
{
    int k;
    c->on_b->set = ECP_I_NEW;
    ecp_i_start_geometric(c, s->h, NULL, ECP_I_FLAT, 0, z + c->at);
    for (k = 0; k <= ecp_i_nf(c); k++) z[c->at + ecp_i_at_p(c) + k] = 0;
    c->on_b->rest = 0;
    if (!(c->on_b->depth > 0)) ecp_i_let_gap_be(s, c, z + c->at);
}

/* The deepest of those that are left out join at z, the last solution: `most` of them at most. How many that are. */
static int ecp_i_join(const ecp_i_island *s, int most, ecp_real *z)
{
    ecp_real least = 0;
    int i, count;
    ecp_i_island_move(s, z);
    for (count = 0; count < most; count++) {
        ecp_i_pair *next = NULL;
        for (i = 0; i < s->all; i++) {
            ecp_i_pair *c = s->pairs[i];
            if (ecp_i_on_plane(c) || c->on_b->set != ECP_I_OUT || !(c->on_b->depth > least))
                continue;
            if (!next || c->on_b->depth > next->on_b->depth) next = c;
        }
        if (!next) break;
        if (count == 0) least = ECP_I_AS_DEEP * next->on_b->depth;
        ecp_i_start_new(s, next, z);
    }
    return count;
}

/* Back to the last solution; those that have joined since then go to the state `set`. */
static void ecp_i_take_back(const ecp_i_island *s, const ecp_i_problem *p, int set, ecp_real *z)
{
    ecp_i_copy(p->n, p->kept, z);
    ecp_i_change_set(s, ECP_I_NEW, set);
    ecp_i_change_set(s, ECP_I_LET, ECP_I_IN);
}

/* A solution without some patches, in which they are apart, to one with all of them, if Newton finds it from there
   at once; or stays where it is. */
static void ecp_i_complete(ecp_i_island *s, const ecp_i_problem *p, const ecp_options *o,
                           ecp_real *z, ecp_i_effort *effort)
{
    int i, most = p->gathered ? ECP_I_COMPLETING_AGAIN : ECP_I_COMPLETING;
    if (s->pair_count == s->all) return;
    for (i = s->pair_count; i < s->all; i++) ecp_i_start_new(s, s->pairs[i], z);
    ecp_i_sort_patches(s);
    if (!ecp_i_spent(effort) && ecp_i_newton(p, 0, o->tolerance, most, 0, z, effort) &&
        !ecp_i_passing(s)) {
        ecp_i_change_set(s, ECP_I_NEW, ECP_I_IN);
        return;
    }
    ecp_i_take_back(s, p, ECP_I_OUT, z);
    ecp_i_sort_patches(s);
    /* a bound on the iterations has ended nothing that is needed */
    if (effort->most < 0) effort->most = 0;
    ecp_i_evaluate(p, z, 0, effort);
}

/* the loop of all this; joined: how many have since the last solution, gone: how often some went since then */
static int ecp_i_island_gather(void *self, const ecp_i_problem *p, const ecp_options *o,
                               ecp_real *z, ecp_i_effort *effort)
{
    ecp_i_island *s = (ecp_i_island *)self;
    int round, set, warm, most = s->all, joined = 0, gone = 0, more = 1;
    int before = effort->iterations;
    /* (one patch alone is no set) */
    if (s->all < 2 || s->arena->overflow || ecp_i_leave_unloaded(s) == 0) return 0;
    effort->fallbacks |= ECP_FALLBACK_WORKING_SET;
    /* the start has the loads of overlaps that are left out as well: an impact is nearer to that, what rests is not */
    if (s->rests) ecp_i_sort_patches(s);
    warm = p->start(s, 0, z);
    for (round = 0; more > 0 && round < ECP_I_GATHERINGS && !ecp_i_spent(effort); round++) {
        ecp_i_sort_patches(s);
        if (ecp_i_newton(p, round == 0 && p->gathered ? warm : 0, o->tolerance, o->max_iterations,
                         0, z, effort)) {
            ecp_i_copy(p->n, z, p->kept);
            ecp_i_find_depths(s, o->tolerance);
            if (joined > 0) most = 2 * most < s->all ? 2 * most : s->all;
            gone = 0;
            joined = more = ecp_i_join(s, most, z);
            if (joined == 0 && !ecp_i_passing(s)) {
                if (effort->iterations > before) ecp_i_complete(s, p, o, z, effort);
                return 1;
            }
        } else if (joined > 1) {
            ecp_i_take_back(s, p, ECP_I_OUT, z);
            most = joined / 4 > 1 ? joined / 4 : 1;
            joined = more = ecp_i_join(s, most, z);
        } else {
            more = gone++ < ECP_I_GOES ? ecp_i_let_go(s, z) : 0;
            if (more > 0 || joined == 0) continue;
            ecp_i_take_back(s, p, ECP_I_TRIED, z);
            gone = 0;
            more = ecp_i_join(s, 1, z);
        }
    }
    for (set = ECP_I_NEW; set <= ECP_I_TRIED; set++) ecp_i_change_set(s, set, ECP_I_IN);
    ecp_i_sort_patches(s);
    return 0;
}

static int ecp_i_island_valid(void *self) { return !ecp_i_passing((const ecp_i_island *)self); }

/* What moves the bodies: their momentum before the step and the impulses of the step. `share` of it
   is taken, so that with nothing of it they stay at rest where they are. */
static void ecp_i_island_load(void *self, ecp_real share)
{
    ecp_i_island *s = (ecp_i_island *)self;
    int i, k;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        ecp_real momentum[6];
        ecp_i_scale(m->mass, m->body->v, momentum);
        ecp_i_spin_momentum(m->R0, m->body->inertia, m->body->v + 3, momentum + 3);
        for (k = 0; k < 6; k++) m->kick[k] = share * m->whole[k] - (1 - share) * momentum[k];
        if (!(share < 1)) ecp_i_copy(6, m->whole, m->kick);
    }
}

/* what a centring step reaches within this part of it has been reached */
#define ECP_I_REACHED ECP_R(1e-3)

/* Friction that sticks, and that a centring step would take beyond its limit: where it has reached that it is held
   there, and where not, *part, of the step, is cut to end there. How many are held now that were not? (Without a load
   the cone has no surface yet: a step that leaves it from its apex is ecp_i_hold_open's to judge, or Newton's to bring
   back.) */
static int ecp_i_hold_friction(const ecp_i_island *s, const ecp_real *z, const ecp_real *dz,
                               ecp_real *part)
{
    int i, k, more = 0;
    for (i = 0; ECP_I_FRICTION && i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        const ecp_real *y = z + c->at + ecp_i_at_p(c), *dy = dz + c->at + ecp_i_at_p(c);
        ecp_real inside = 0, ahead = 0, bend = 0, root;
        if (ecp_i_nf(c) == 0 || c->held || !c->may_stick) continue;
        if (ecp_i_body_count(s) == 1 && y[0] < ecp_i_kink(1) / 2) continue;
        /* |y + t dy|^2 = mu^2 (p + t dp)^2 at t = inside / root */
        for (k = 0; k <= ecp_i_nf(c); k++) {
            ecp_real sign = k > 0 ? ECP_R(1) : -c->mu * c->mu;
            inside -= sign * y[k] * y[k];
            ahead += sign * y[k] * dy[k];
            bend += sign * dy[k] * dy[k];
        }
        inside = ecp_i_max(inside, 0);
        root = ahead * ahead + bend * inside;
        if (!(root >= 0)) continue;
        root = ahead + ecp_i_sqrt(root);
        if (!(root > 0)) continue;
        if (inside < ECP_I_REACHED * root) {
            c->held = 1;
            more++;
        } else {
            *part = ecp_i_min(*part, inside / root);
        }
    }
    return more;
}

/* Impulses that are zero, and that a centring step would make negative. With friction this is the apex of a cone, and
   what the step asks for says nothing about its rays: first a little of the one along its friction is tried, at the
   limit; what would end there as well stays at zero. How many are held, or tried, now that were not? z is a solution no
   more where it is not 0. */
static int ecp_i_hold_open(const ecp_i_island *s, ecp_real *z, const ecp_real *dz)
{
    ecp_real little = ecp_i_kink(1) / 2;
    int i, k, more = 0;
    for (i = 0; ecp_i_body_count(s) == 1 && i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_real *y = z + c->at + ecp_i_at_p(c), size = 0;
        const ecp_real *dy = dz + c->at + ecp_i_at_p(c);
        if (c->open || !(y[0] + dy[0] < 0 && y[0] < -ECP_I_REACHED * dy[0])) continue;
        for (k = 1; k <= ecp_i_nf(c); k++) size += dy[k] * dy[k];
        c->open = c->held || !(size > 0) || !(y[0] < little);
        c->held = !c->open;
        if (c->held) {
            y[0] = little;
            for (k = 1; k <= ecp_i_nf(c); k++) y[k] = c->mu * little * dy[k] / ecp_i_sqrt(size);
        }
        more++;
    }
    return more;
}

/* Newton steps with the slopes of F from here on (ecp_i_multiplier_row) */
static void ecp_i_untilt(const ecp_i_island *s)
{
    int i;
    for (i = 0; i < s->pair_count; i++) s->pairs[i]->tilt = 1;
}

static void ecp_i_free_impulses(const ecp_i_island *s)
{
    int i;
    for (i = 0; i < s->pair_count; i++) s->pairs[i]->held = s->pairs[i]->open = 0;
}

/* Along a limit of friction, which is curved, whole steps go to and fro about their end. From the step before, of which
   the part t led from `best` to z: the part of this one that ends there if that is so. */
static ecp_real ecp_i_centring_pace(const ecp_i_island *s, const ecp_real *z, const ecp_real *best,
                                    const ecp_real *dz, ecp_real t)
{
    ecp_real along = 0, size = 0;
    int i, k;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        int at = c->at + ecp_i_at_p(c);
        for (k = at; k <= at + ecp_i_nf(c); k++) {
            along += (z[k] - best[k]) * dz[k];
            size += (z[k] - best[k]) * (z[k] - best[k]);
        }
    }
    return size > 0 ? 1 / ecp_i_max(1, 1 / t - along / size) : ECP_R(1);
}

/* Are all constraints f at the ECP kept within `slack` or loaded, by the multipliers? */
static int ecp_i_is_inside(int count, const ecp_real *f, const ecp_real *multipliers,
                           ecp_real slack)
{
    int j;
    for (j = 0; j < count; j++) {
        if (!(f[j] <= slack || multipliers[j] > ecp_i_sqrt(ECP_I_EPSILON))) return 0;
    }
    return 1;
}

/* does the ECP stay on both primitives when it moves by da (frame of A, metres) from y? */
static int ecp_i_stays_on(ecp_i_pair *c, const ecp_real *y, const ecp_real da[3])
{
    ecp_real a[3], world[3], b[3], slack = ecp_i_sqrt(ECP_I_EPSILON) * c->L;
    ecp_i_scale(c->L, y, a);
    ecp_i_add(a, da, a);
    ecp_i_pair_place(c, a);
    if (!ecp_i_is_inside(c->nl, c->fa, y + 3, slack)) return 0;
    if (ecp_i_on_plane(c)) return 1;
    ecp_i_mul(c->Qa, da, world);
    ecp_i_mul_t(c->Qb, world, b);
    ecp_i_add(c->on_b->b_local, b, b);
    c->b->shape.cls->eval(&c->b->shape, b, c->on_b->fb, c->on_b->gb);
    return ecp_i_is_inside(c->nm, c->on_b->fb, y + ecp_i_at_m(c), slack);
}

/* keeps a centring step among the solutions: of the part `most` the largest of 1, 1/2, 1/4, .. for which no ECP leaves
   its primitive sideways, cut where a normal impulse would turn negative */
static ecp_real ecp_i_centring_length(const ecp_i_island *s, const ecp_real *z, const ecp_real *dz,
                                      ecp_real most)
{
    ecp_real t = 1, da[3];
    int i, inside;
    for (i = 0; i < s->pair_count; i++) {
        int at = s->pairs[i]->at + ecp_i_at_p(s->pairs[i]);
        if (z[at] > 0 && z[at] + most * dz[at] < 0) most = -z[at] / dz[at];
    }
    for (; t > ECP_R(1e-3); t /= 2) {
        for (i = 0, inside = 1; inside && i < s->pair_count; i++) {
            ecp_i_pair *c = s->pairs[i];
            ecp_i_scale(t * most * c->L, dz + c->at, da);
            inside = ecp_i_stays_on(c, z + c->at, da);
        }
        if (inside) return t * most;
    }
    return 0;
}

/* A centring step comes nearer to its end by its square. The third in a row that is not half of the one before, or
   that something other than friction cuts, goes to and fro between two faces or over an edge, and centring ends. */
#define ECP_I_TO_AND_FRO 3

/* The rule ECP_CENTRED. From a solution z: the step that stays on the solutions to first order and ends nearest to the
   centres, then Newton back on to them, until nothing moves. Where friction at its limit would go beyond, it is held
   and the step found anew; what is held is let go once more at the end. Returns 0 where that is not reached: an ECP or
   a normal impulse at its limit is in the way, or z, which stays as it was then, solves the equations to a tolerance
   that the other does not. Large islands, which seldom reach it, get fewer iterations, and no other round after one
   that gets no nearer. */
static int ecp_i_centre(ecp_i_island *s, const ecp_i_problem *p, const ecp_i_step *step,
                        ecp_real *z, ecp_real *best, ecp_i_effort *effort)
{
    ecp_real size, before = 0, t = 1, pace, part;
    ecp_real most = ecp_i_max(step->o->tolerance, effort->size.largest);
    int round, i, more, held = 0, asked = 0, moved = 0, idle = 0, large = ecp_i_is_large(p);
    /* z is no solution, `best` was the last one; the step leads too far from a primitive for one */
    int astray = 0, lost = 0;
    ecp_i_free_impulses(s);
    ecp_i_untilt(s); /* what rests turns no more, and its ECPs are near their rims */
    for (round = 0; round < 20; round++) {
        s->centring = 1;
        i = p->step(s, z, p->F, 1, 0, p->dz);
        s->centring = 0;
        if (!i) break;
        if (ECP_I_ASKS_AGAIN && !s->many && held == 0) return 1;
        step->r->centring_rounds++;
        for (i = 0, size = 0; i < s->pair_count; i++) {
            const ecp_i_pair *c = s->pairs[i];
            const ecp_real *dy = p->dz + c->at;
            ecp_real way = ecp_i_largest(3, dy);
            /* (where there is but one solution the step is Newton's, and may be long) */
            lost |= s->many && way * c->L > 4 * c->a->shape.radius;
            size =
                ecp_i_max(size, ecp_i_max(way, ecp_i_largest(1 + ecp_i_nf(c), dy + ecp_i_at_p(c))));
        }
        if (lost) break;
        part = pace = before > 0 ? ecp_i_centring_pace(s, z, best, p->dz, t) : ECP_R(1);
        more = ecp_i_hold_friction(s, z, p->dz, &part);
        held += more;
        if (more > 0) continue;
        if (!astray) ecp_i_copy(p->n, z, best);
        more = ecp_i_hold_open(s, z, p->dz);
        if (more > 0) {
            p->residual(s, z, 0, p->F, &effort->size);
            held += more;
            astray = 1;
            before = 0;
            continue;
        }
        if (before > 0) idle = 2 * size > before ? idle + (large ? ECP_I_TO_AND_FRO : 1) : 0;
        if (idle >= ECP_I_TO_AND_FRO) break;
        t = ecp_i_centring_length(s, z, p->dz, part);
        if (t < part) idle++;
        /* one that is cut says nothing of the next one */
        before = t < pace && !large ? ECP_R(0) : size;
        for (i = 0; i < p->n; i++) z[i] += t * p->dz[i];
        astray = 1;
        if (ecp_i_newton(p, 0, step->o->tolerance, large ? 3 : 10, 0, z, effort) &&
            effort->size.largest <= most) {
            astray = 0;
            if (size > ecp_i_sqrt(step->o->tolerance) / 10) {
                moved = 1;
            } else {
                /* is there what would rather leave its limit? */
                if (held == 0 || (asked && !moved)) return 1;
                asked = 1;
                moved = 0;
                ecp_i_free_impulses(s);
                held = 0;
            }
            if (t > 0) continue;
        }
        break;
    }
    if (astray) {
        ecp_i_copy(p->n, best, z);
        p->residual(s, z, 0, p->F, &effort->size);
    }
    return 0;
}

/* How far apart the primitives of a patch are, at its last evaluation: along its normal as A has it; if they overlap, as
   B has it, should that show more. (On a large face the rounding of the normal on a curve is an overlap, far away.) */
static ecp_real ecp_i_pair_separation(ecp_i_pair *c, const ecp_real *y)
{
    ecp_i_posed A, B;
    ecp_real unit[3], at[3] = {0, 0, 0}, gap;
    int i;
    ecp_i_copy(9, c->Qa, A.Q);
    ecp_i_copy(9, c->Qb, B.Q);
    ecp_i_pose_turned(c, 0, 1, &A);
    ecp_i_pose_turned(c, 1, 1, &B);
    if (ecp_i_on_plane(c)) return ecp_i_plane_gap(&A, &B, 0, unit, at);
    ecp_i_copy3(c->n, unit);
    ecp_i_normalise(unit);
    gap = ecp_i_separation(&A, &B, unit);
    if (gap >= 0) return gap;
    for (i = 0; i < c->nm; i++) ecp_i_axpy(at, -y[ecp_i_at_m(c) + i], c->on_b->gb + 3 * i, at);
    ecp_i_mul(c->Qb, at, unit);
    return ecp_i_normalise(unit) ? ecp_i_max(gap, ecp_i_separation(&A, &B, unit)) : gap;
}

/* is friction within its cone, to the tolerance? */
static int ecp_i_sticks(const ecp_i_pair *c, ecp_real tolerance)
{
    ecp_i_projection q;
    ecp_i_cone_project(c, c->rho, &q);
    return !(q.z_norm - q.radius > 10 * tolerance);
}

/* the contact record of a patch at its last evaluation, and its separation; the memory is zero before */
static void ecp_i_record(ecp_i_pair *c, const ecp_real *y, ecp_real h, const ecp_options *o)
{
    const ecp_i_body *body = c->ma->body;
    ecp_contact *k = &c->record->contact;
    ecp_real centre[3];
    c->record->centred = o->rule == ECP_CENTRED;
    k->shape_a = c->shape_a;
    k->shape_b = c->shape_b;
    k->body_a = c->a->body;
    k->body_b = c->b->body;
    ecp_i_scale(c->L, y, c->record->a);
    ecp_i_add(body->x_carry, c->ma->dx, centre);
    ecp_i_add(body->x, centre, centre);
    ecp_i_add(centre, c->ra, k->point_a);
    ecp_i_axpy(k->point_a, c->d, c->n, k->point_b);
    ecp_i_copy3(c->N, k->normal);
    k->gap = c->d;
    k->separation = ecp_i_pair_separation(c, y);
    if (ECP_I_FRICTION) {
        k->mu = c->mu;
        k->e_t = c->e[0];
        k->e_o = c->e[1];
        k->e_r = c->e[2];
    }
    ecp_i_copy(c->nl, y + 3, c->multipliers);
    if (!ecp_i_on_plane(c)) ecp_i_copy(c->nm, y + ecp_i_at_m(c), c->multipliers + c->nl);
    k->mode = ECP_APART;
    if (ecp_i_nf(c) == 0) ecp_i_tangents(c);
    ecp_i_copy3(c->t, k->direction_t);
    ecp_i_copy3(c->o, k->direction_o);
    /* of p_n and d one is zero: the larger one, in its unit, says which (both may be below zero, by rounding and what
       gaps are granted) */
    if (!(ecp_i_light_unit(c) * c->p[0] > ecp_i_max(0, ecp_i_row_gap(c) / (h * c->V)))) return;
    k->p_n = c->P * c->p[0];
    k->mode = ECP_SLIP;
    if (ecp_i_nf(c) == 0) return;
    k->p_t = c->e[0] * c->P * c->p[1];
    k->p_o = c->e[1] * c->P * c->p[2];
    k->p_r = ecp_i_torsion(c);
    if (ecp_i_sticks(c, o->tolerance)) {
        k->mode = ECP_STICK;
        return;
    }
    k->sigma = c->V * ecp_i_norm(c->slip);
}

/* max of |y| - mu p_n, in N s */
static ecp_real ecp_i_cone_violation(const ecp_i_pair *c)
{
    ecp_real size = 0;
    int k;
    for (k = 1; k <= ecp_i_nf(c); k++) size += c->p[k] * c->p[k];
    return c->P * (ecp_i_sqrt(size) - c->mu * c->p[0]);
}

/* The memory does not suffice for this island: the bytes of the whole block that would do, and those
   that there are. */
static ecp_status ecp_i_no_room(ecp_i_step *step, const ecp_i_island *s, int label)
{
    /* (a number that a float rounds may come out lower) */
    size_t spare = step->w->bytes - step->arena.size, wants = ecp_i_island_wants(s) + spare;
    ecp_real value = (ecp_real)wants;
    return ecp_i_fail(step->r, ECP_CAPACITY, label, -1, -1, value + value * ECP_I_EPSILON,
                      (ecp_real)step->w->bytes);
}

/* The most work of contacts that may pass for the curvature of their gaps: with 0.1 a rolling hexagon wins by it what it
   loses on its edges. Within ecp_advance extrapolation takes the curvature out, and parts would be in its way. */
#define ECP_I_MOST_WORK ECP_R(0.01)
#define ECP_I_MOST_WORK_ADVANCING ECP_R(0.1)

static ecp_real ecp_i_most_work(const ecp_world *w)
{
    return w->advancing ? ECP_I_MOST_WORK_ADVANCING : ECP_I_MOST_WORK;
}

/* the shortest part of a step that is cut for it */
#define ECP_I_NOT_SO_SHORT (ECP_R(1.0) / 128)

/* twice the most kinetic energy that a body has in the step, before it, after it or in free motion */
static ecp_real ecp_i_most_energy(const ecp_i_motion *m)
{
    ecp_real L[3], predicted[6], most = 0;
    const ecp_real *v[3];
    int k;
    for (k = 0; k < 6; k++) predicted[k] = m->body->v[k] + m->free[k];
    v[0] = m->body->v;
    v[1] = predicted;
    v[2] = m->v;
    for (k = 0; k < 3; k++) {
        ecp_i_mul(m->inertia, v[k] + 3, L);
        most = ecp_i_max(most, m->mass * ecp_i_dot(v[k], v[k]) + ecp_i_dot(v[k] + 3, L));
    }
    return most;
}

/* The work of the island's contacts: the sum of p . v, v at the end of the step, in units of the energy of its
   bodies (ecp_i_most_energy), of a ten-thousandth of m vs^2 at least. The kinetic energy is that of the free motion,
   plus this, less |dv|^2_M / 2, dv what the contacts change. Gaps close with p_n v_n <= 0 and friction opposes slip,
   so it is not positive, but for what pushes overlaps apart (taken off twice, as it turns bodies: given up for parts of
   the step it would push in each of them as hard, in a part of the time), for rounding (where that may be all that is
   too much, the work is the limit), and for the curvature of gaps, which is little while turns are small. If it is
   large the solution is another one, far away: a body shot out from between two. */
static ecp_real ecp_i_contact_work(const ecp_i_island *s, ecp_real tolerance)
{
    ecp_real work = 0, granted = 0, unit = 0, excess, speed = ecp_i_mover(s, 0)->speed, v[3];
    ecp_real most = ecp_i_most_work(s->world);
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        const ecp_i_motion *m = ecp_i_mover(s, i);
        unit += ecp_i_max(ecp_i_most_energy(m), ECP_R(1e-4) * m->mass * speed * speed);
    }
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        ecp_i_pair_velocity(c, v);
        work += ecp_i_dot(c->force, v);
        if (ecp_i_nf(c) == 3) work += ecp_i_torsion(c) * ecp_i_dot(c->N, c->spin);
    }
    for (i = 0; work > most * unit && i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        /* (not by the last step's gap: a body may have been put elsewhere) */
        ecp_real load = c->P * c->p[0] / s->h;
        work -= 2 * load * ecp_i_depth(c, NULL, v);
        /* velocities that rounding of gaps makes in the shortest parts would win more than these */
        granted += load * (c->d_floor + 4 * tolerance * c->L);
        granted += ecp_i_norm(c->force) / ECP_I_NOT_SO_SHORT *
                   ecp_i_max(ecp_i_max(c->ma->noise, c->ma->jitter),
                             ecp_i_max(c->mb->noise, c->mb->jitter));
    }
    excess = (work - granted) / unit;
    work /= unit;
    if (excess <= most) work = ecp_i_min(work, most);
    return ecp_i_finite(work) ? work : 0;
}

/* A step sees its bodies where it begins and where it ends. One that turns by this much (rad) or more may have been
   through the other in between, by this much of the smaller one: in a step of 90 degrees a cube goes from one face
   to the next, none of which does any work, and rolls for ever. */
#define ECP_I_WIDE_TURN ECP_R(0.25)
#define ECP_I_MOST_MIDWAY ECP_R(0.02)

/* how deep the pair's primitives are in each other, at the end of the trial motion or where the step begins; 0 or less
   if they are apart */
static ecp_real ecp_i_pair_overlap(const ecp_i_pair *c, int at_end)
{
    ecp_i_posed A, B;
    ecp_real a[3], b[3], n[3];
    ecp_i_poses(c, at_end, &A, &B);
    if (ecp_i_on_plane(c)) return -ecp_i_plane_gap(&A, &B, 0, n, a);
    return ecp_i_distance(&A, &B, a, b, n) > 0 ? ECP_R(0) : ecp_i_overlap(&A, &B, n);
}

/* where the velocities that they have take the bodies of a pair within h */
static void ecp_i_move_pair(const ecp_i_pair *c, ecp_real h)
{
    ecp_real dv[6];
    ecp_i_copy(6, c->ma->dv, dv);
    c->ma->turns = c->mb->turns = 0;
    ecp_i_move(c->ma, h, dv);
    ecp_i_copy(6, c->mb->dv, dv);
    ecp_i_move(c->mb, h, dv);
}

/* The most that a pair of the island, one of which turns widely, overlaps half way of the step, beyond what it did
   where it began, in radii of the smaller one. */
static ecp_real ecp_i_midway(const ecp_i_island *s)
{
    ecp_real most = 0;
    int i;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        ecp_real turn = ecp_i_max(ecp_i_norm(c->ma->v + 3), ecp_i_norm(c->mb->v + 3)), depth;
        ecp_real size = c->a->shape.radius;
        if (!(s->h * turn > ECP_I_WIDE_TURN)) continue;
        if (!ecp_i_on_plane(c)) size = ecp_i_min(size, c->b->shape.radius);
        ecp_i_move_pair(c, s->h / 2);
        depth = ecp_i_pair_overlap(c, 1);
        ecp_i_move_pair(c, s->h);
        if (depth > 0) depth -= ecp_i_max(0, ecp_i_pair_overlap(c, 0));
        most = ecp_i_max(most, depth / size);
    }
    return ecp_i_finite(most) ? most : 0;
}

/* may there be a better solution in shorter steps, by the work of the contacts or by what is half way? */
static int ecp_i_is_doubtful(const ecp_world *w, const ecp_report *r)
{
    return r->work > ecp_i_most_work(w) || r->midway > ECP_I_MOST_MIDWAY;
}

/* In options.fallbacks of what is tried under a bound on the iterations when it holds in reserve what a solution has
   taken, to solve it once more. */
#define ECP_I_IN_RESERVE 0x8000

/* Is a solution given up? Only where sub-steps may be used, and under a bound only one that is in reserve. */
static int ecp_i_gives_up(const ecp_world *w, const ecp_options *o, const ecp_report *r)
{
    return ecp_i_may(o, ECP_FALLBACK_SUBSTEPS) &&
           (o->max_total_iterations == 0 || (o->fallbacks & ECP_I_IN_RESERVE)) &&
           ecp_i_is_doubtful(w, r);
}

/* Is a step that is solved under a bound given up before it is taken? Its iterations must fit once more. */
static int ecp_i_reserves(const ecp_world *w, const ecp_options *o, int reserve,
                          const ecp_report *r)
{
    return ecp_i_may(o, ECP_FALLBACK_SUBSTEPS) && o->max_total_iterations > 0 && !w->advancing &&
           reserve < ecp_i_effort_after(o, r->iterations).most && ecp_i_is_doubtful(w, r);
}

/* the island of the bodies and patches listed under this label, and where their unknowns stand */
static void ecp_i_gather_island(const ecp_i_step *step, int label, ecp_i_island *s)
{
    int i;
    s->body_count = s->pair_count = 0;
    for (i = label; i >= 0; i = ECP_I_PAIRS ? step->motions[i].next_body : -1) {
        step->motions[i].at = 6 * s->body_count;
        s->bodies[s->body_count++] = i;
    }
    s->unknowns = 6 * s->body_count;
    for (i = step->motions[label].first_pair; i >= 0; i = step->pairs[i].next_pair) {
        ecp_i_pair *c = step->pairs + i;
        c->at = s->unknowns;
        s->unknowns += c->count;
        s->pairs[s->pair_count++] = c;
    }
    if (ECP_I_PAIRS) s->all = s->pair_count;
}

/* the patch whose rows, or whose bodies' momentum, are missed the most */
static const ecp_i_pair *ecp_i_worst_pair(const ecp_i_island *s, const ecp_real *F)
{
    const ecp_i_pair *worst = s->pairs[0];
    ecp_real most = -1;
    int i;
    for (i = 0; ECP_I_PAIRS && i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        ecp_real size = ecp_i_largest(c->count, F + c->at);
        if (ecp_i_moves_a(c)) size = ecp_i_max(size, ecp_i_largest(6, F + c->ma->at));
        if (ecp_i_moves_b(c)) size = ecp_i_max(size, ecp_i_largest(6, F + c->mb->at));
        if (size > most) {
            worst = c;
            most = size;
        }
    }
    return worst;
}

/* not solved, at that patch, whose first body that moves is named: the value met and the one it must
   meet */
static ecp_status ecp_i_not_solved(const ecp_i_step *step, const ecp_i_pair *c, ecp_real value,
                                   ecp_real limit)
{
    const ecp_i_part *moves = ecp_i_moves_a(c) ? c->a : c->b;
    return ecp_i_fail(step->r, ECP_NOT_SOLVED, moves->body, c->shape_a, c->shape_b, value, limit);
}

/* what an island's equations need of the step; its bodies and patches */
static void ecp_i_open_island(ecp_i_step *step, int label, ecp_i_island *s)
{
    s->centring = s->many = s->uncentred = s->in_vain = 0;
    s->rests = 0;
    s->dropped = 0;
    s->chord = 0;
    s->loose = 0;
    s->tree.fronts = NULL;
    s->tree.planned = 0;
    s->motions = step->motions + (ECP_I_PAIRS ? 0 : label);
    s->bodies = step->bodies;
    s->pairs = step->members;
    s->arena = &step->arena;
    s->h = step->h;
    s->world = step->w;
    s->nearest = step->o->rule == ECP_NEAREST;
    s->tolerance = step->o->tolerance;
    s->noise = s->tolerance / 10;
    s->turn = ecp_i_content(step->o->tolerance);
    ecp_i_gather_island(step, label, s);
}

/* the island as Newton sees it; the first vector is the unknowns */
static void ecp_i_island_problem(ecp_i_island *s, ecp_real *const *vectors, ecp_i_problem *p)
{
    p->self = s;
    p->n = s->unknowns;
    p->velocities = 6 * ecp_i_body_count(s);
    p->residual = ecp_i_island_residual;
    p->step = ecp_i_island_step;
    p->start = ecp_i_island_start;
    /* what nobody asks for is not set */
    if (ECP_I_PAIRS) {
        p->large = ecp_i_island_is_large(s);
        p->again = ecp_i_island_again;
        p->turn = ecp_i_island_turn;
        p->event = ECP_I_EVENTS && s->body_count > 1 ? ecp_i_island_event : NULL;
        p->valid = ecp_i_island_valid;
        p->gather = (ECPSIM_FALLBACKS)&ECP_FALLBACK_WORKING_SET ? ecp_i_island_gather : NULL;
        p->gathered = p->calm = 0;
    }
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_GEOMETRIC) p->repair = ecp_i_island_repair;
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_LOAD) p->load = ecp_i_island_load;
    p->F = vectors[1];
    p->kept = vectors[2];
    p->dz = vectors[3];
    p->trial = vectors[4];
    p->drift = vectors[5];
    if (ECP_I_VECTORS > 6) p->stalled = vectors[ECP_I_VECTORS - 1];
}

/* Three bodies and more that the first starts (and, of large islands, continuation in haste) do not solve are
   sooner solved in shorter steps than by what is left of the chain, which seldom leads anywhere in heaps. */
static int ecp_i_hurries(const ecp_i_step *step, const ecp_i_island *s)
{
    const int parts = (ECPSIM_FALLBACKS)&ECP_FALLBACK_SUBSTEPS;
    return ECP_I_PAIRS && parts != 0 && step->cut && s->body_count > 2;
}

/* The velocities that bodies keep follow from the impulses reported, which push both of a pair alike. Where the noise
   of gaps is granted to the balance of momentum, or to a contact that is open (in float, in short steps, more than
   slow bodies have), that of z would win or lose what is granted in every step. The poses stay those of z, in which
   nothing overlaps. */
static void ecp_i_island_balance(const ecp_i_island *s)
{
    int i, k;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        const ecp_real *missed = m->residual;
        ecp_real dv[6];
        if (ecp_i_largest(3, missed) <= 16 * ECP_I_EPSILON * m->floor[0] &&
            ecp_i_largest(3, missed + 3) <= 16 * ECP_I_EPSILON * m->floor[1])
            continue;
        ecp_i_velocity_change(m, missed, dv);
        for (k = 0; k < 6; k++) m->dv[k] -= dv[k];
    }
}

/* In options.fallbacks of a step that is solved once more: along the chord from the first start on. */
#define ECP_I_CHORD_FIRST 0x4000

/* The whole chain: in float first with normals held to rounding, and if that finds nothing with the tolerance alone and
   the slopes of F; last along the chord of the step. */
static int ecp_i_solve_equations(ecp_i_island *s, const ecp_i_problem *p, const ecp_options *o,
                                 ecp_real *z, ecp_i_effort *effort)
{
    int solved = 0;
    if (!((ECPSIM_FALLBACKS)&ECP_FALLBACK_CHORD) || !(o->fallbacks & ECP_I_CHORD_FIRST)) {
        do {
            if (s->loose) ecp_i_untilt(s);
            solved = ecp_i_solve(p, o, z, effort);
        } while (!solved && ECP_I_STRICT_NORMALS && !ecp_i_spent(effort) && !s->loose++);
    }
    if (!solved && ECP_I_FRICTION && ecp_i_may(o, ECP_FALLBACK_CHORD) && !ecp_i_in_haste(p) &&
        !ecp_i_spent(effort)) {
        effort->fallbacks |= ECP_FALLBACK_CHORD;
        s->chord = s->h;
        solved = ecp_i_solve(p, o, z, effort);
    }
    return solved;
}

/* How an island was solved, which its patches keep for the next step: without some of them, with many iterations, with
   its bodies at rest from the beginning on. */
enum { ECP_I_GATHERED = 1, ECP_I_LABOURED = 2, ECP_I_RESTED = 4 };

/* From how many iterations on a step is laboured; what an attempt to come to rest may take, of Newton from one start,
   and in all. */
#define ECP_I_LABOUR 5
#define ECP_I_RESTING 5
#define ECP_I_RESTING_IN_ALL 40

/* Velocities, in units vs, that may be dropped where bodies come to rest: what tolerances and rounding make of an
   impact at some hundred times vs. */
#ifdef ECPSIM_FLOAT
#define ECP_I_SLOW ECP_R(1e-3)
#else
#define ECP_I_SLOW ECP_R(3e-9)
#endif

/* the course of all patches that the island had in the last step */
static int ecp_i_last_course(const ecp_i_island *s)
{
    int i, course = 0;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        if (c->old >= 0) course |= ecp_i_patches(s->world)[c->old].course;
    }
    return course;
}

/* The frame in which bodies come to rest: that of a belt or a lift that carries all of them, which goes on as it does.
   The world's, where what they touch has several velocities, or turns. */
static void ecp_i_find_carrier(const ecp_i_island *s, ecp_real carrier[3])
{
    const ecp_i_motion *first = NULL;
    int i;
    ECPSIM_MEMSET(carrier, 0, 3 * sizeof(ecp_real));
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        const ecp_i_motion *m = c->ma->dynamic ? c->mb : c->ma;
        if (m->dynamic) continue;
        if (!first) first = m;
        if (!ecp_i_equal(m->body->v, first->body->v) || ecp_i_largest(3, m->body->v + 3) > 0)
            return;
    }
    if (first) ecp_i_copy3(first->body->v, carrier);
}

/* what stands still, in the same units */
#define ECP_I_STANDS ECP_R(1e-3)

/* Are all velocities below that limit, but for noise: at the beginning of the step, or at its end? Those in the frame
   that carries the island. The limit is in units vs, but never more than of g h: a light body under a load makes vs
   large for all that it touches. Of noise the beginning takes as much again at most: in short steps it is more than g
   h, and what falls must not begin at rest. */
static int ecp_i_is_slow(const ecp_i_island *s, const ecp_real carrier[3], ecp_real limit, int end)
{
    ecp_real fall = limit * s->h * ecp_i_norm(s->world->desc.gravity);
    int i;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        const ecp_i_motion *m = ecp_i_mover(s, i);
        const ecp_real *v = end ? m->v : m->body->v;
        ecp_real noise =
            end ? m->noise + m->jitter
                : ecp_i_min(ECP_I_POSE_ROUNDING * ECP_I_EPSILON * m->length / s->h, fall);
        ecp_real most = ecp_i_min(limit * m->speed, fall) + noise, slides[3];
        ecp_i_sub(v, carrier, slides);
        if (!(ecp_i_largest(3, slides) <= most && m->length * ecp_i_largest(3, v + 3) <= most))
            return 0;
    }
    return 1;
}

/* takes the momentum that the bodies begin the step with, in the frame that carries them, off what moves them; or not,
   as it was */
static void ecp_i_drop_momentum(ecp_i_island *s, const ecp_real carrier[3], int drop)
{
    int i, k;
    s->rests = drop;
    s->dropped = 0;
    for (i = 0; i < ecp_i_body_count(s); i++) {
        ecp_i_motion *m = ecp_i_mover(s, i);
        ecp_real v[6], momentum[6];
        for (k = 0; k < 6; k++) {
            v[k] = k < 3 ? m->body->v[k] - carrier[k] : m->body->v[k];
            v[k] = drop ? v[k] + m->body->v_carry[k] : ECP_R(0);
        }
        ecp_i_raise(&s->dropped, ecp_i_norm(v));
        ecp_i_raise(&s->dropped, m->length * ecp_i_norm(v + 3));
        ecp_i_scale(m->mass, v, momentum);
        ecp_i_spin_momentum(m->R0, m->body->inertia, v + 3, momentum + 3);
        for (k = 0; k < 6; k++) m->kick[k] = m->whole[k] - momentum[k];
        ecp_i_velocity_change(m, m->kick, m->free);
    }
}

/* Bodies that touch each other come to rest. In a jam, as of flush crates that were dropped, an impact leaves gaps
   and impulses within the tolerance of its speeds, which at rest ask for velocities far below all that matters but far
   above the tolerance. A turn about the normal of its contacts nothing resists, so they go on, push others, and each
   step is a jam anew. So where the last step has laboured, or has come out of this, and nothing is faster than
   ECP_I_SLOW, the step begins without their momentum, and gaps within what a certificate lets pass are left as they
   are. What does not end as slow, or takes long, is solved as ever. */
static int ecp_i_come_to_rest(ecp_i_island *s, ecp_i_problem *p, const ecp_options *o, int *course,
                              ecp_real *z, ecp_i_effort *effort)
{
    ecp_options quick = *o;
    ecp_real carrier[3];
    int solved, most = effort->most, bound = effort->iterations + ECP_I_RESTING_IN_ALL;
    if (s->body_count < 2 || !(s->course & (ECP_I_LABOURED | ECP_I_RESTED)) || s->world->advancing)
        return 0;
    ecp_i_find_carrier(s, carrier);
    if (!ecp_i_is_slow(s, carrier, ECP_I_SLOW, 0)) return 0;
    if (quick.max_iterations > ECP_I_RESTING) quick.max_iterations = ECP_I_RESTING;
    quick.fallbacks &= ECP_FALLBACK_WORKING_SET;
    if (most > bound) effort->most = bound;
    p->calm = 1;
    ecp_i_drop_momentum(s, carrier, 1);
    solved = ecp_i_attempt(p, p->start(s, 0, z), &quick, z, effort) && ecp_i_island_valid(s) &&
             ecp_i_is_slow(s, carrier, ECP_I_SLOW, 1);
    p->calm = 0;
    if (most > bound) effort->most = most;
    if (solved)
        *course = ecp_i_is_slow(s, carrier, o->tolerance, 1) ? ECP_I_RESTED : ECP_I_LABOURED;
    else
        ecp_i_drop_momentum(s, carrier, 0);
    return solved;
}

/* What friction can hold it may as well let go: a pyramid of balls has solutions in which it stands and others in which
   it comes apart, and it is chance which of them Newton finds. So where all stands still when the step begins, and does
   not in the solution z, one is looked for in which it does. If what slips also opened, by mu times its slip, the step
   would be a convex program, with one answer, in which all stands if it can; and there the two problems are the same.
   Sweeps over spots find where that is (ECP_I_START_HELD); Newton goes on from there with the velocities that they
   leave, or with none, and never farther off. */
static void ecp_i_hold(ecp_i_island *s, ecp_i_problem *p, const ecp_options *o, ecp_real *z,
                       ecp_i_effort *effort)
{
    ecp_real carrier[3];
    int k, held = 0, many = s->many;
    size_t used, top;
    if (s->body_count < 2 || !ecp_i_may(o, ECP_FALLBACK_GEOMETRIC)) return;
    ecp_i_find_carrier(s, carrier);
    if (!ecp_i_is_slow(s, carrier, 0, 0) || ecp_i_is_slow(s, carrier, ECP_I_STANDS, 1)) return;
    ecp_i_copy(p->n, z, p->kept);
    ecp_i_change_set(s, ECP_I_OUT, ECP_I_NEW);
    ecp_i_sort_patches(s);
    used = s->arena->used;
    top = s->arena->top;
    p->calm = 1;
    for (k = 0; k < 2 && !held && !ecp_i_spent(effort) && p->start(s, ECP_I_START_HELD, z); k++) {
        if (k > 0) ECPSIM_MEMSET(z, 0, (size_t)p->velocities * sizeof(ecp_real));
        held = ecp_i_newton(p, 0, o->tolerance, o->max_iterations, 0, z, effort) &&
               ecp_i_island_valid(s) && ecp_i_is_slow(s, carrier, ECP_I_STANDS, 1);
    }
    p->calm = 0;
    if (held) {
        ecp_i_change_set(s, ECP_I_NEW, ECP_I_IN);
        effort->fallbacks |= ECP_FALLBACK_GEOMETRIC;
        return;
    }
    ecp_i_take_back(s, p, ECP_I_OUT, z);
    ecp_i_sort_patches(s);
    s->many = many;
    /* (neither a bound on the iterations nor want of memory has ended what is needed) */
    ecp_i_release(s->arena, used, top);
    s->arena->overflow = 0;
    if (effort->most < 0) effort->most = 0;
    ecp_i_evaluate(p, z, 0, effort);
}

/* The whole chain, after an attempt to come to rest. course: ECP_I_GATHERED and others. */
static int ecp_i_solve_in_course(ecp_i_island *s, ecp_i_problem *p, const ecp_options *o,
                                 int *course, ecp_real *z, ecp_i_effort *effort)
{
    int solved, before;
    *course = 0;
    s->course = ecp_i_last_course(s);
    p->gathered = s->course & ECP_I_GATHERED;
    solved = ecp_i_come_to_rest(s, p, o, course, z, effort);
    before = effort->iterations;
    if (!solved) {
        solved = ecp_i_solve_equations(s, p, o, z, effort);
        if (effort->iterations > before + ECP_I_LABOUR) *course = ECP_I_LABOURED;
        if (ECP_I_HOLDS && solved) ecp_i_hold(s, p, o, z, effort);
    }
    if (s->pair_count < s->all) *course |= ECP_I_GATHERED;
    return solved;
}

/* adds an island to the report */
static void ecp_i_count_island(const ecp_i_step *step, const ecp_i_island *s,
                               const ecp_i_effort *effort, ecp_real merit)
{
    ecp_report *r = step->r;
    r->islands++;
    r->unknowns += s->unknowns;
    r->iterations += effort->iterations;
    r->evaluations += effort->evaluations;
    r->fallbacks |= effort->fallbacks;
    r->merit += merit;
    if (ECP_I_PAIRS) ecp_i_raise(&r->dropped, s->dropped);
    ecp_i_worst(&r->natural_residual, effort->size.largest);
}

/* Is what the chain ended with a solution to keep? F: its residual, the last one that was evaluated. */
static ecp_status ecp_i_judge(const ecp_i_step *step, const ecp_i_island *s,
                              const ecp_i_effort *effort, const ecp_real *F, ecp_real merit,
                              int solved)
{
    const ecp_options *o = step->o;
    /* near overflow rounding floors let anything pass */
    ecp_real error = solved ? effort->size.largest : effort->size.error;
    if (!solved || !ecp_i_finite(merit)) {
        const ecp_i_pair *c = ECP_I_PAIRS && error <= o->tolerance ? ecp_i_passing(s) : NULL;
        if (c) return ecp_i_not_solved(step, c, ecp_i_passes(c, c->n), 0);
        return ecp_i_not_solved(step, ecp_i_worst_pair(s, F), error, o->tolerance);
    }
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_SUBSTEPS) {
        ecp_real work = ecp_i_contact_work(s, o->tolerance);
        ecp_i_worst(&step->r->work, work);
        if (!step->w->advancing) ecp_i_worst(&step->r->midway, ecp_i_midway(s));
        if (ecp_i_gives_up(step->w, o, step->r)) {
            return work > ecp_i_most_work(step->w)
                       ? ecp_i_not_solved(step, s->pairs[0], work, ecp_i_most_work(step->w))
                       : ecp_i_not_solved(step, s->pairs[0], step->r->midway, ECP_I_MOST_MIDWAY);
        }
    }
    return ECP_OK;
}

/* What a patch has of an impulse that its record does not show, so little that it is granted, its bodies do not keep
   (ecp_i_island_balance). */
static void ecp_i_drop_impulse(const ecp_i_pair *c)
{
    if (ecp_i_moves_a(c)) ecp_i_wrench(c, c->ma, c->ra, -1);
    if (ecp_i_moves_b(c)) ecp_i_wrench(c, c->mb, c->rb, 1);
}

/* the records of the island's patches, from its solution z, but for those left out; centred: 1, 0 if the bound on
   iterations ended the centring or there was none, -1 if it was in vain */
static void ecp_i_record_island(ecp_i_step *step, ecp_i_island *s, const ecp_real *z, int label,
                                int centred, int course)
{
    int i;
    ecp_i_carve_records(step, label);
    for (i = 0; i < s->pair_count; i++) {
        ecp_i_pair *c = s->pairs[i];
        ecp_i_record(c, z + c->at, s->h, step->o);
        if (!(c->record->contact.p_n > 0)) ecp_i_drop_impulse(c);
        if (centred <= 0) c->record->centred = (signed char)centred;
        if (ECP_I_PAIRS) c->record->course = (signed char)course;
        if (!ECP_I_FRICTION) continue;
        ecp_i_raise(&step->r->worst_cone, ecp_i_cone_violation(c));
    }
    if (ECP_I_PAIRS) step->without += s->all - s->pair_count;
}

/* Is the ECP of a load on the rim of its face without being held there, or friction at its limit without slip, or does
   a patch touch without a load? The last elimination may have come before it was let go, or with the rows of slip or
   of what is apart, and says nothing of how many solutions there are. */
static int ecp_i_on_a_kink(const ecp_i_island *s, const ecp_real *z, ecp_real tiny)
{
    int i, j;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        if (!(z[c->at + ecp_i_at_p(c)] > tiny)) {
            if (ecp_i_abs(ecp_i_row_gap(c)) <= tiny * s->h * c->V + c->d_floor) return 1;
            continue;
        }
        if (ecp_i_nf(c) > 0) {
            ecp_i_projection q;
            ecp_i_cone_project(c, ecp_i_rho(c), &q);
            if (q.z_norm >= q.radius - tiny && q.taken < ecp_i_kink(1)) return 1;
        }
        for (j = 0; j < c->nl; j++) {
            if (c->fa[j] > -tiny * c->L && z[c->at + 3 + j] <= tiny) return 1;
        }
        for (j = 0; j < ecp_i_nm(c); j++) {
            if (c->on_b->fb[j] > -tiny * c->L && z[c->at + ecp_i_at_m(c) + j] <= tiny) return 1;
        }
    }
    return 0;
}

/* Centres the solution z, if there may be others or it comes from a point that was not centred. Returns 0 where that is
   not reached or z is left uncentred. whole: nothing is left out; what is left out is apart in this solution, and need
   not be in another one. */
static int ecp_i_centre_island(ecp_i_step *step, ecp_i_island *s, const ecp_i_problem *p,
                               ecp_real *z, ecp_real *best, ecp_i_effort *effort, int whole)
{
    int moved = effort->iterations > 0;
    if (s->many || s->uncentred || (moved && ecp_i_on_a_kink(s, z, step->o->tolerance))) {
        return whole ? ecp_i_centre(s, p, step, z, best, effort) : 0;
    }
    /* what rests uncentred is left alone */
    return moved || !s->in_vain;
}

static ecp_status ecp_i_solve_island(ecp_i_step *step, int label)
{
    ecp_i_island s;
    ecp_i_problem p;
    const ecp_options *o = step->o;
    ecp_i_effort effort = ecp_i_effort_after(o, step->r->iterations);
    ecp_real *vectors[ECP_I_VECTORS], *z, *best, merit;
    ecp_status status;
    size_t mark = step->arena.used;
    int solved, whole, centred = 1, course = 0;
    ecp_i_open_island(step, label, &s);
    if (s.pair_count == 0) return ECP_OK;
    ecp_i_carve_vectors(&step->arena, s.unknowns, vectors);
    ECPSIM_ASSERT(!step->arena.overflow);
    s.begin = step->arena.used;
    z = vectors[0];
    best = vectors[2];
    ecp_i_island_problem(&s, vectors, &p);
    ecp_i_island_units(&s);
    if (ECP_I_GIVES_UP) {
        p.patient = ecp_i_body_count(&s) > 2 || !ecp_i_may(o, ECP_I_RESTARTS);
    }
    if (ECP_I_PAIRS) p.hurries = ecp_i_hurries(step, &s);
    if (ecp_i_in_haste(&p)) *step->cut = 1;
    if (ECP_I_PAIRS)
        solved = ecp_i_solve_in_course(&s, &p, o, &course, z, &effort);
    else
        solved = ecp_i_solve_equations(&s, &p, o, z, &effort);
    whole = !ECP_I_PAIRS || s.pair_count == s.all;
    if (ECP_I_CENTRING && solved && o->rule == ECP_CENTRED) {
        centred = ecp_i_centre_island(step, &s, &p, z, best, &effort, whole);
        step->r->centred &= centred;
    }
    if (step->arena.overflow) return ecp_i_no_room(step, &s, label);
    if (!solved) p.residual(&s, z, 0, p.F, &effort.size);
    if (ecp_i_watched(step) && !ecp_i_unbound(o, &effort)) {
        step->motions[label].stirred = 1; /* does not sleep */
    }
    merit = ecp_i_merit(p.n, p.F);
    ecp_i_count_island(step, &s, &effort, merit);
    status = ecp_i_judge(step, &s, &effort, p.F, merit, solved);
    if (status != ECP_OK) return status;
    /* what was not written need not be cleared */
    if (effort.evaluations == 1 && effort.fallbacks == 0 && step->arena.used == s.begin) {
        step->arena.used = (size_t)((unsigned char *)best - step->arena.base);
    }
    /* of all this memory only z is needed any more */
    ecp_i_release(&step->arena, mark + ecp_i_bytes((size_t)s.unknowns, sizeof(ecp_real)),
                  step->arena.top);
    if (!centred && whole && effort.most >= 0) centred = -1;
    ecp_i_record_island(step, &s, z, label, centred, course);
    if (!(s.still && effort.iterations == 0)) ecp_i_island_balance(&s);
    if (ecp_i_in_haste(&p)) *step->cut = 0;
    return ECP_OK;
}

/* solves all islands, and again with the pairs that turned out to touch */
static ecp_status ecp_i_solve_all(ecp_i_step *s)
{
    ecp_status status = ECP_OK;
    size_t mark = s->arena.used;
    int i, extras = -1;
    while (s->extras > extras) {
        ecp_i_release(&s->arena, mark, s->arena.top);
        if (extras >= 0) ECPSIM_MEMSET(s->arena.base + mark, 0, s->arena.high - mark);
        extras = s->extras;
        s->r->unknowns = s->r->islands = 0;
        if (ECP_I_PAIRS) s->without = 0;
        s->r->centred = s->o->rule == ECP_CENTRED;
        s->r->worst_cone = s->r->merit = s->r->natural_residual = 0;
        if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_SUBSTEPS) s->r->work = s->r->midway = 0;
        for (i = 0; extras > 0 && i < s->w->bodies; i++) {
            ecp_i_motion *m = s->motions + i;
            if (!m->dynamic) continue;
            m->turns = 0; /* its pose is not that of m->dv (ecp_i_island_balance) */
            ecp_i_move(m, s->h, m->free);
        }
        status = ecp_i_find_pairs(s);
        if (status != ECP_OK) return status;
        ecp_i_label_islands(s);
        ecp_i_mark_stirred(s);
        for (i = 0; i < s->w->bodies; i++) {
            if (s->motions[i].island != i) continue;
            if (ecp_i_island_sleeps(s, i)) {
                ecp_i_keep_island(s, i);
                continue;
            }
            status = ecp_i_solve_island(s, i);
            if (status != ECP_OK) return status;
        }
        ecp_i_find_touching(s);
    }
    return ECP_OK;
}

/* the independent check: by their support functions, all patches are apart along their normals */
static ecp_status ecp_i_verify(ecp_i_step *s)
{
    int i, first = 0;
    s->r->worst_gap = 0;
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        ecp_real radius = ecp_i_on_plane(c) ? c->a->shape.radius
                                            : ecp_i_min(c->a->shape.radius, c->b->shape.radius);
        ecp_real size = ecp_i_min(s->h * c->V, ECP_I_FAR_RADII * radius) + radius;
        ecp_real limit = -c->d_floor - 4 * s->o->tolerance * size, gap;
        if (ecp_i_left_out(c)) {
            first += i == first;
            continue; /* was verified when it was left out */
        }
        gap = c->record->contact.separation;
        if (i == first || gap < s->r->worst_gap) s->r->worst_gap = gap;
        if (ecp_i_is_asleep(c->ma) || ecp_i_is_asleep(c->mb))
            continue; /* was verified when it fell asleep */
        if (!(gap >= limit)) {
            return ecp_i_not_solved(s, c, gap, limit);
        }
    }
    return ECP_OK;
}

/* x += dx with the rounding error kept for the next time (Knuth's two-sum) */
static void ecp_i_add_carried(ecp_real *x, ecp_real *carry, ecp_real dx)
{
    ecp_real a = *x, b = *carry + dx, sum = a + b, b_part = sum - a;
    *carry = (a - (sum - b_part)) + (b - b_part);
    *x = sum;
}

/* q turned by the half tangents u (h w / 2), its rounding error kept in the same way: in float a step of 0.1 ms at 1e-3
   rad/s is a rounding unit of it. q keeps its length, or comes back to it. */
static void ecp_i_turn_carried(ecp_i_body *b, const ecp_real u[3])
{
    ecp_real turn[4], by[4], uu = ecp_i_dot(u, u), root = ecp_i_sqrt(1 + uu),
                             along = uu / (1 + root);
    ecp_real over = b->q[0] * b->q[0] + ecp_i_dot(b->q + 1, b->q + 1) - 1;
    int k;
    if (!(uu > 0)) return;
    turn[0] = 0;
    ecp_i_copy3(u, turn + 1);
    ecp_quat_multiply(turn, b->q, by);
    if (ecp_i_abs(over) > 8 * ECP_I_EPSILON) along += over / 2;
    for (k = 0; k < 4; k++)
        ecp_i_add_carried(b->q + k, b->q_carry + k, (by[k] - along * b->q[k]) / root);
}

/* the same by the angular velocity w for the time h */
static void ecp_i_turn_for(ecp_i_body *b, const ecp_real w[3], ecp_real h)
{
    ecp_real u[3];
    ecp_i_scale(h / 2, w, u);
    ecp_i_turn_carried(b, u);
}

static ecp_status ecp_i_check_turn(ecp_i_step *s, int body, const ecp_real w[3])
{
    int k;
    for (k = 0; k < 3; k++) {
        ecp_real turn = ecp_i_abs(s->h * w[k]);
        if (turn <= ECP_I_SQUARABLE) continue;
        return ecp_i_fail(s->r, ECP_NOT_FINITE, body, -1, -1, turn, ECP_I_SQUARABLE);
    }
    return ECP_OK;
}

static ecp_status ecp_i_commit(ecp_i_step *s)
{
    ecp_world *w = s->w;
    ecp_i_body *bodies = ecp_i_bodies(w);
    int i, k;
    for (i = 0; i < w->bodies; i++) {
        const ecp_i_motion *m = s->motions + i;
        if (bodies[i].kind == ECP_STATIC || bodies[i].kind == ECP_I_FREE) continue;
        if (ecp_i_check_turn(s, i, m->v + 3) != ECP_OK) return ECP_NOT_FINITE;
        /* two finite numbers may have no finite sum */
        for (k = 0; k < 3; k++) {
            ecp_real x = bodies[i].x[k] + (bodies[i].x_carry[k] + m->dx[k]);
            if (ecp_i_finite(x) && ecp_i_finite(m->v[k])) continue;
            return ecp_i_fail(s->r, ECP_NOT_FINITE, i, -1, -1, ecp_i_finite(x) ? m->v[k] : x, 0);
        }
    }
    for (i = 0; i < w->bodies; i++) {
        const ecp_i_motion *m = s->motions + i;
        ecp_i_body *b = bodies + i, before;
        if (ECP_I_SLEEP && b->kind == ECP_STATIC) b->asleep = ecp_i_watched(s);
        if (b->kind == ECP_STATIC || b->kind == ECP_I_FREE || ecp_i_is_asleep(m)) continue;
        if (ecp_i_watched(s)) ECPSIM_MEMCPY(&before, b, sizeof before);
        /* turns below the rounding of q are lost where bodies touch each other: there it is the rounding of gaps that asks
           for them, without end, if they came true (in float crates side by side would not come to rest) */
        if (ECP_I_PAIRS && m->dynamic && s->motions[m->island].next_body >= 0)
            ecp_quat_advance(b->q, m->v + 3, s->h, b->q);
        else
            ecp_i_turn_for(b, m->v + 3, s->h);
        for (k = 0; k < 3; k++) ecp_i_add_carried(b->x + k, b->x_carry + k, m->dx[k]);
        for (k = 0; m->dynamic && k < 6; k++) {
            ecp_i_add_carried(b->v + k, b->v_carry + k, m->dv[k]);
            b->force[k] = b->impulse[k] = 0;
        }
        if (ecp_i_watched(s)) b->asleep = w->last_h == s->h && ecp_i_is_still(&before, b);
    }
    ecp_i_end_sleep(s);
    w->last_h = s->h;
    for (i = 0, k = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs + i;
        if (ecp_i_left_out(c)) continue;
        ECPSIM_MEMCPY(ecp_i_patches(w) + k, c->record, sizeof(ecp_i_patch));
        ecp_i_copy(w->desc.max_inequalities, c->multipliers, ecp_i_multipliers(w, k));
        k++;
    }
    w->patches = k;
    return ECP_OK;
}

/* One step of the length h, all or nothing; the report adds up. `spare` bytes at the end of the
   block are somebody else's. cut: NULL, or 0, and set to 1 where the step fails by an island that was given
   up early (ecp_i_hurries), to ECP_I_RESERVED where it is solved and not taken (ecp_i_reserves). */
#define ECP_I_RESERVED 2

static ecp_status ecp_i_step_once(ecp_world *world, ecp_real h, const ecp_options *o, size_t spare,
                                  int *cut, ecp_report *r)
{
    ecp_i_step s;
    ecp_status status = ECP_OK;
    int i, asleep;
    if ((ECPSIM_FALLBACKS)&ECP_FALLBACK_SUBSTEPS) s.cut = cut;
    s.extras = s.pair_count = s.has_sleepers = 0;
    if (ECP_I_PAIRS) s.without = 0;
    s.w = world;
    s.h = h;
    s.o = o;
    s.r = r;
    s.arena = ecp_i_arena_over(world, world->bytes - spare);
    s.arena.used = s.arena.high = world->state_bytes;
    ecp_i_carve_step(&s.arena, world->bodies, world->shapes, world->desc.max_patches, &s);
    ecp_i_begin_sleep(&s, spare > 0);
    asleep = ecp_i_world_sleeps(&s);
    for (i = 0; !asleep && i < world->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(world) + i;
        if (ecp_i_sleepers(&s)) s.motions[i].quiet = b->asleep != 0;
        if (b->kind != ECP_I_FREE) ecp_i_predict(world, b, h, s.motions + i);
        if (b->kind == ECP_KINEMATIC && status == ECP_OK) {
            status = ecp_i_check_turn(&s, i, b->v + 3);
        }
    }
    if (status == ECP_OK && !asleep) status = ecp_i_solve_all(&s);
    r->patches_kept = s.pair_count - (ECP_I_PAIRS ? s.without : 0);
    r->patches_left_out = ecp_i_count_pairs(&s) - r->patches_kept;
    if (status == ECP_OK && !asleep) status = ecp_i_verify(&s);
    if (status == ECP_OK && cut && ecp_i_reserves(world, o, r->iterations, r)) {
        *cut = ECP_I_RESERVED;
        status = ECP_NOT_SOLVED;
    }
    if (status == ECP_OK && !asleep) status = ecp_i_commit(&s);
    for (i = 0; status == ECP_OK && i < world->bodies; i++) {
        ecp_i_raise(&r->largest_turn, h * ecp_i_norm(s.motions[i].v + 3));
    }
    ecp_i_arena_mark(&s.arena);
    if (s.arena.most + spare > r->memory_used) r->memory_used = s.arena.most + spare;
    /* work memory is zero outside a call: a failed step leaves no trace */
    ECPSIM_MEMSET(s.arena.base + world->state_bytes, 0, s.arena.high - world->state_bytes);
    ECPSIM_MEMSET(s.arena.base + s.arena.low, 0, s.arena.size - s.arena.low);
    return status;
}

/* sub-steps of one step, and how short they may be: h / 2^20, or h / 2^7 (ECP_I_NOT_SO_SHORT) in haste and where
   contacts do work */
#define ECP_I_SUBSTEPS 256
#define ECP_I_SHORTEST (ECP_R(1.0) / 1048576)
#define ECP_I_SHORT (ECP_R(1.0) / 1024)

/* After this many times max_iterations, counted for each unknown, no further sub-step is tried, but not before
   as many iterations as all that was tried before the parts has taken, in haste twice as many: islands of
   thousands of unknowns would have nothing left for them. */
#define ECP_I_EFFORT ECP_R(60000.0)

/* have the parts of a step, tried since `before` iterations, taken as many as they may? */
static int ecp_i_tires(const ecp_options *o, int hasty, int before, const ecp_report *r)
{
    ecp_real taken = (ecp_real)r->iterations - (ecp_real)before;
    return ecp_i_effort_after(o, r->iterations).most == 0 ||
           (taken * (ecp_real)r->unknowns > ECP_I_EFFORT * (ecp_real)o->max_iterations &&
            taken >= (ecp_real)(1 + hasty) * (ecp_real)before);
}

/* of several sub-steps the report has what is worst in any: `worst` has it of those before this one */
static void ecp_i_report_part(ecp_report *r, ecp_report *worst)
{
    if (r->substeps > 0) {
        ecp_i_worst(&r->work, worst->work);
        ecp_i_worst(&r->midway, worst->midway);
        ecp_i_worst(&r->merit, worst->merit);
        ecp_i_worst(&r->natural_residual, worst->natural_residual);
        ecp_i_worst(&r->worst_cone, worst->worst_cone);
        r->worst_gap = ecp_i_min(r->worst_gap, worst->worst_gap);
        r->centred &= worst->centred;
    }
    r->substeps++;
    *worst = *r;
}

/* The step in parts, which grow by 2 where they succeed, up to half of the last that failed, and shrink
   by 4 where they fail, so that what makes trouble is passed in short ones; only the shortest take the dearer
   fallbacks, and in haste (ecp_i_hurries) there are none so short. In haste they begin with other lengths, as
   what is tried after it without would otherwise end in the same jam. Forces act in all of them, impulses in the
   first. before: the bodies as the step found them. *given_up: whether any solution was
   (ecp_i_gives_up). */
static ecp_status ecp_i_take_parts(ecp_world *world, ecp_real h, const ecp_options *o, size_t spare,
                                   int hasty, const ecp_i_body *before, int *given_up,
                                   ecp_report *r)
{
    ecp_real rest = 1, part = hasty ? ECP_R(0.25) : ECP_R(0.5), most = 1;
    ecp_options quick = *o;
    ecp_report worst = *r;
    ecp_status status;
    int i, cut = 0, iterations = r->iterations;
    quick.fallbacks &= ECP_FALLBACK_WORKING_SET | ECP_FALLBACK_GEOMETRIC |
                       ECP_FALLBACK_CONTINUATION | ECP_FALLBACK_SUBSTEPS | ECP_I_IN_RESERVE;
    r->substeps = 0;
    while (rest > 0) {
        status = ecp_i_step_once(world, h * part, part > ECP_I_SHORT ? &quick : o, spare,
                                 hasty ? &cut : NULL, r);
        if (status == ECP_OK) {
            rest -= part;
            part = ecp_i_min(ecp_i_min(2 * part, most), rest);
            for (i = 0; rest > 0 && i < world->bodies; i++) {
                ECPSIM_MEMCPY(ecp_i_bodies(world)[i].force, before[i].force,
                              sizeof before[i].force);
            }
            ecp_i_report_part(r, &worst);
            if (r->substeps == ECP_I_SUBSTEPS && rest > 0) status = ECP_NOT_SOLVED;
            if (rest > 0 && ecp_i_effort_after(o, r->iterations).most == 0) status = ECP_NOT_SOLVED;
            if (status == ECP_OK) continue;
        }
        *given_up |= ecp_i_gives_up(world, o, r);
        most = part / 2;
        part /= 4;
        if (status != ECP_NOT_SOLVED ||
            part < (hasty || *given_up ? ECP_I_NOT_SO_SHORT : ECP_I_SHORTEST) ||
            r->substeps == ECP_I_SUBSTEPS || ecp_i_tires(o, hasty, iterations, r)) {
            return status;
        }
    }
    return ECP_OK;
}

/* A step that has failed, in parts; if it was given up early (cut) first in haste, then whole with all
   fallbacks. If there is no way but by what is given up, the whole step along the chord: what spins in a wedge may
   be held there, where the printed slip only lets it be shot out. If that is none either contacts may do work, but
   where there is a solution in reserve: in the whole step, or else in parts again. saved: the state before. */
static ecp_status ecp_i_try_parts(ecp_world *world, ecp_real h, const ecp_options *o, size_t spare,
                                  const unsigned char *saved, int cut, ecp_report *r)
{
    const ecp_i_body *before = (const ecp_i_body *)(const void *)(saved + world->bodies_at);
    ecp_options lenient = *o, chord = *o;
    ecp_status status = ECP_NOT_SOLVED;
    int k, last = 2, given_up = ecp_i_gives_up(world, o, r);
    lenient.fallbacks &= ~ECP_FALLBACK_SUBSTEPS;
    chord.fallbacks |= ECP_I_CHORD_FIRST;
    for (k = cut ? 0 : 2; k <= last && status == ECP_NOT_SOLVED; k++) {
        const ecp_options *way = k > 3 ? &lenient : k == 3 ? &chord : o;
        if (k == 3 && !(ECP_I_FRICTION && ecp_i_may(o, ECP_FALLBACK_CHORD))) continue;
        ECPSIM_MEMCPY(world, saved, world->state_bytes);
        r->substeps = 1;
        if (k == 1 || k == 3 || k == 4) {
            status = ecp_i_step_once(world, h, way, spare, NULL, r);
            given_up |= ecp_i_gives_up(world, way, r);
        } else {
            status = ecp_i_take_parts(world, h, way, spare, k == 0, before, &given_up, r);
        }
        if (k == 2 && given_up) {
            last = o->fallbacks & ECP_I_IN_RESERVE ? 3 : 5;
            given_up = 0;
        }
        if (ecp_i_effort_after(o, r->iterations).most == 0) break;
    }
    return status;
}

/* Under a bound on the iterations what is solved first is not given up. If it is doubtful, and the bound leaves more
   than it has taken (`reserve`), the rest is spent on a better one; if there is none it is solved once more. */
static ecp_status ecp_i_try_within(ecp_world *world, ecp_real h, const ecp_options *o, size_t spare,
                                   const unsigned char *saved, int cut, ecp_report *r)
{
    ecp_options first = *o, better = *o;
    ecp_status status;
    int reserve = r->iterations, whole = cut == ECP_I_RESERVED, hasty = 0;
    first.fallbacks &= ~ECP_FALLBACK_SUBSTEPS;
    if (!whole) {
        status = ecp_i_try_parts(world, h, &first, spare, saved, cut, r);
        reserve = r->iterations - reserve;
        if (status != ECP_OK || !ecp_i_reserves(world, o, reserve, r)) return status;
    }
    better.fallbacks |= ECP_I_IN_RESERVE;
    better.max_total_iterations -= reserve;
    status = ecp_i_try_parts(world, h, &better, spare, saved, whole ? 0 : cut, r);
    if (status == ECP_OK) return status;
    if (!whole) return ecp_i_try_parts(world, h, &first, spare, saved, cut, r);
    ECPSIM_MEMCPY(world, saved, world->state_bytes);
    r->substeps = 1;
    return ecp_i_step_once(world, h, &first, spare, &hasty, r);
}

/* a report of no failure: what has failed on the way to a step that is solved is nobody's concern */
static void ecp_i_clear_failure(ecp_report *r)
{
    r->body = r->shape_a = r->shape_b = -1;
    r->value = r->limit = 0;
}

/* a step that has failed in parts, or some other way; the state before is kept at the end of the block */
static ecp_status ecp_i_step_by_parts(ecp_world *world, ecp_real h, const ecp_options *o,
                                      size_t spare, int cut, ecp_report *r)
{
    size_t bytes = world->state_bytes;
    unsigned char *saved = (unsigned char *)world + world->bytes - spare - bytes;
    ecp_status status;
    ECPSIM_MEMCPY(saved, world, bytes);
    r->fallbacks |= ECP_FALLBACK_SUBSTEPS;
    spare += bytes;
    if (o->max_total_iterations > 0)
        status = ecp_i_try_within(world, h, o, spare, saved, cut, r);
    else
        status = ecp_i_try_parts(world, h, o, spare, saved, cut, r);
    if (status != ECP_OK) ECPSIM_MEMCPY(world, saved, bytes);
    ECPSIM_MEMSET(saved, 0, bytes);
    return status;
}

ECP_DEF ecp_status ecp_step(ecp_world *world, ecp_real h, const ecp_options *options,
                            ecp_report *report)
{
    ecp_options o = ecp_options_default();
    ecp_report r;
    ecp_status status;
    ECPSIM_MEMSET(&r, 0, sizeof r);
    r.body = r.shape_a = r.shape_b = -1;
    if (options) o = *options;
    status = world ? ecp_i_check_options(&o) : ECP_BAD_POINTER;
    /* within a callback of ecp_advance */
    if (status == ECP_OK && world->advancing) status = ECP_BAD_OPTION;
    if (status == ECP_OK && !ecp_i_finite(h))
        status = ecp_i_fail(&r, ECP_NOT_FINITE, -1, -1, -1, h, 0);
    if (status == ECP_OK && !(h > 0)) status = ecp_i_fail(&r, ECP_BAD_STEP, -1, -1, -1, h, 0);
    if (status == ECP_OK) {
        int parts = ecp_i_may(&o, ECP_FALLBACK_SUBSTEPS), cut = 0;
        r.substeps = 1;
        status = ecp_i_step_once(world, h, &o, 0, parts ? &cut : NULL, &r);
        if (status == ECP_NOT_SOLVED && parts && ecp_i_effort_after(&o, r.iterations).most > 0) {
            status = ecp_i_step_by_parts(world, h, &o, 0, cut, &r);
        }
    }
    if (status == ECP_OK) ecp_i_clear_failure(&r);
    r.centred &= status == ECP_OK;
    r.status = status;
    if (report) *report = r;
    if (status == ECP_NOT_SOLVED && o.dump) o.dump(world, h, &o, o.dump_write, o.dump_user);
    return status;
}

/* >>contacts */

ECP_DEF int ecp_contact_count(const ecp_world *world)
{
    int i, count = 0;
    for (i = 0; world && i < world->patches; i++) count += !ecp_i_patches(world)[i].guess;
    return count;
}

ECP_DEF ecp_status ecp_contact_get(const ecp_world *world, int index, ecp_contact *contact)
{
    int i, count = 0;
    if (!world || !contact) return ECP_BAD_POINTER;
    for (i = 0; i < world->patches; i++) {
        const ecp_i_patch *p = ecp_i_patches(world) + i;
        if (p->guess || count++ != index) continue;
        *contact = p->contact;
        return ECP_OK;
    }
    return ECP_BAD_INDEX;
}

ECP_DEF ecp_status ecp_guess_ecp(ecp_world *world, int shape_a, int shape_b,
                                 const ecp_real point[3])
{
    const ecp_i_part *parts;
    ecp_i_patch *list, *p;
    ecp_real x[3], R[9], rel[3], local[3];
    int i, at = 0, lo = shape_a < shape_b ? shape_a : shape_b,
           hi = shape_a < shape_b ? shape_b : shape_a;
    if (!world || !point) return ECP_BAD_POINTER;
    if (world->advancing) return ECP_BAD_OPTION;
    if (!ecp_i_find_part(world, lo) || !ecp_i_find_part(world, hi) || lo == hi) {
        return ECP_BAD_INDEX;
    }
    if (!ecp_i_all_finite(3, point)) return ECP_NOT_FINITE;
    parts = ecp_i_parts(world);
    /* the ECP is kept on the primitive that a patch of the two calls A */
    shape_a = parts[lo].shape.kind == ECP_HALF_SPACE ? hi : lo;
    shape_b = lo + hi - shape_a;
    if (parts[shape_a].shape.kind == ECP_HALF_SPACE || parts[lo].body == parts[hi].body ||
        (!ECP_I_PAIRS && parts[shape_b].shape.kind != ECP_HALF_SPACE) ||
        (ecp_i_bodies(world)[parts[lo].body].kind != ECP_DYNAMIC &&
         ecp_i_bodies(world)[parts[hi].body].kind != ECP_DYNAMIC)) {
        return ECP_BAD_KIND;
    }
    ecp_shape_get(world, shape_a, NULL, NULL, x, R);
    ecp_i_sub(point, x, rel);
    ecp_i_mul_t(R, rel, local);
    if (!ecp_i_all_finite(3, local)) return ECP_NOT_FINITE;
    list = ecp_i_patches(world);
    while (at < world->patches && ecp_i_patch_before(list + at, lo, hi)) at++;
    if (at == world->patches || !ecp_i_patch_is(list + at, lo, hi)) {
        if (world->patches == world->desc.max_patches) return ECP_CAPACITY;
        for (i = world->patches++; i > at; i--) {
            ECPSIM_MEMCPY(list + i, list + i - 1, sizeof *list);
            ECPSIM_MEMCPY(ecp_i_multipliers(world, i), ecp_i_multipliers(world, i - 1),
                          (size_t)world->desc.max_inequalities * sizeof(ecp_real));
        }
    }
    p = list + at;
    ECPSIM_MEMSET(p, 0, sizeof *p);
    p->guess = 1;
    p->contact.shape_a = shape_a;
    p->contact.shape_b = shape_b;
    p->contact.body_a = parts[shape_a].body;
    p->contact.body_b = parts[shape_b].body;
    ecp_i_wake(world, p->contact.body_a);
    ecp_i_wake(world, p->contact.body_b);
    ecp_i_copy3(local, p->a);
    return ECP_OK;
}

/* >>advance ===============================================================================
   A macro step of the length H is done by 1, 2, .., K base steps, K times from the same state. While
   the contacts stay as they are the results differ by a series in powers of the base step, and
   Aitken-Neville takes K - 1 terms off (T_KK). Extrapolated are the changes over the macro step:
   displacement, the Cayley vector of the turn, velocity. What contacts do (their phase: which patches
   carry, stick or slip, on which faces) is compared over all base steps, and with what the state at
   the beginning allows, because error estimates are blind where all columns change alike. */

static void ecp_i_carve_advance(ecp_i_arena *arena, const ecp_world *w, ecp_i_advance *a)
{
    const ecp_world_desc *d = &w->desc;
    a->first = (unsigned char *)ecp_i_take(arena, w->state_bytes, 1);
    a->saved = (unsigned char *)ecp_i_take(arena, w->state_bytes, 1);
    a->row = 12 * d->max_bodies + ECP_I_FORCES * d->max_patches;
    a->rows = ecp_i_take_reals(arena, d->advance_order, a->row);
    a->rate = ecp_i_take_reals(arena, 6, d->max_bodies);
    a->rate_now = ecp_i_take_reals(arena, 6, d->max_bodies);
    a->values = ecp_i_take_reals(arena, 4, d->max_inequalities);
    a->last = (ecp_i_phase *)ecp_i_take(arena, (size_t)d->max_patches, sizeof(ecp_i_phase));
    a->now = (ecp_i_phase *)ecp_i_take(arena, (size_t)d->max_patches, sizeof(ecp_i_phase));
    a->here = (ecp_i_phase *)ecp_i_take(arena, (size_t)d->max_patches, sizeof(ecp_i_phase));
}

/* the state at the beginning of the macro step, or of all, as a world to be read */
static const ecp_world *ecp_i_snapshot(const unsigned char *saved)
{
    return (const ecp_world *)(const void *)saved;
}

/* ---- phases */

/* which of the multipliers are on: f at the ECP, beside them */
static uint64_t ecp_i_faces(const ecp_i_advance *a, const ecp_shape *shape, ecp_real length,
                            const ecp_real x[3], const ecp_real *l)
{
    uint64_t faces = 0;
    int i;
    shape->cls->eval(shape, x, a->values, NULL);
    for (i = 0; i < shape->inequalities; i++) {
        if (l[i] > -a->values[i] / length) faces |= (uint64_t)1 << (i % 64);
    }
    return faces;
}

/* where a primitive is whose body is turned by q, with its centre of mass at x */
static void ecp_i_pose_part(const ecp_i_part *part, const ecp_real q[4], const ecp_real x[3],
                            ecp_i_posed *p)
{
    ecp_real R[9];
    ecp_quat_to_matrix(q, R);
    p->shape = &part->shape;
    if (ECP_I_PAIRS) ecp_i_set3(0, 0, 0, p->way);
    ecp_i_matmul(R, part->rotation, p->Q);
    ecp_i_mul(R, part->position, p->x);
    ecp_i_add(p->x, x, p->x);
}

/* where a primitive is, relative to `origin` */
static void ecp_i_pose_of(const ecp_world *w, int shape, const ecp_real origin[3], ecp_i_posed *p)
{
    const ecp_i_part *part = ecp_i_parts(w) + shape;
    const ecp_i_body *b = ecp_i_bodies(w) + part->body;
    ecp_real x[3];
    ecp_i_sub(b->x, origin, x);
    ecp_i_add(x, b->x_carry, x);
    ecp_i_pose_part(part, b->q, x, p);
}

static const ecp_i_body *ecp_i_body_of(const ecp_world *w, int shape)
{
    return ecp_i_bodies(w) + ecp_i_parts(w)[shape].body;
}

/* the body by which a patch's lengths and speeds are measured: A's, or B's where A does not give way */
static const ecp_i_body *ecp_i_giving(const ecp_i_body *ba, const ecp_i_body *bb)
{
    return ba->kind == ECP_DYNAMIC ? ba : bb;
}

/* L of the patch's multipliers (ecp_i_island_units) */
static ecp_real ecp_i_patch_length(const ecp_i_body *ba, const ecp_i_body *bb)
{
    if (ba->kind == ECP_DYNAMIC && bb->kind == ECP_DYNAMIC) {
        return ecp_i_min(ba->length, bb->length);
    }
    return ecp_i_giving(ba, bb)->length;
}

/* the ECP of a contact in the frame of B, where the world has it now */
static void ecp_i_ecp_on_b(const ecp_world *w, const ecp_contact *c, ecp_real b[3])
{
    ecp_real x[3];
    ecp_i_posed B;
    ecp_i_pose_of(w, c->shape_b, c->point_b, &B);
    ecp_i_scale(-1, B.x, x);
    ecp_i_mul_t(B.Q, x, b);
}

/* the radius of the smaller primitive of the patch */
static ecp_real ecp_i_phase_radius(const ecp_world *w, const ecp_i_phase *f)
{
    const ecp_shape *a = &ecp_i_parts(w)[f->shape_a].shape;
    const ecp_shape *b = &ecp_i_parts(w)[f->shape_b].shape;
    return b->kind == ECP_HALF_SPACE ? a->radius : ecp_i_min(a->radius, b->radius);
}

/* Lists what the patches that carry do. */
static int ecp_i_phases(const ecp_i_advance *a, ecp_i_phase *list)
{
    const ecp_world *w = a->w;
    const ecp_i_part *parts = ecp_i_parts(w);
    int i, count = 0;
    for (i = 0; i < w->patches; i++) {
        const ecp_i_patch *p = ecp_i_patches(w) + i;
        const ecp_contact *c = &p->contact;
        const ecp_shape *sa = &parts[c->shape_a].shape, *sb = &parts[c->shape_b].shape;
        const ecp_real *l = ecp_i_multipliers(w, i);
        ecp_i_phase *f = list + count;
        ecp_real y[3], length;
        if (p->guess || c->mode == ECP_APART) continue;
        count++;
        ECPSIM_MEMSET(f, 0, sizeof *f);
        f->shape_a = c->shape_a;
        f->shape_b = c->shape_b;
        f->mode = c->mode;
        ecp_i_copy3(p->a, f->a);
        ecp_i_copy3(c->normal, f->N);
        length = ecp_i_patch_length(ecp_i_body_of(w, c->shape_a), ecp_i_body_of(w, c->shape_b));
        f->faces[0] = ecp_i_faces(a, sa, length, p->a, l);
        if (sb->kind != ECP_HALF_SPACE) {
            ecp_real b[3];
            ecp_i_ecp_on_b(w, c, b);
            f->faces[1] = ecp_i_faces(a, sb, length, b, l + sa->inequalities);
        }
        f->mu = c->mu;
        f->p_n[0] = c->p_n;
        if (!(c->mu > 0)) continue;
        ecp_i_scale(c->p_t, c->direction_t, f->friction);
        ecp_i_axpy(f->friction, c->p_o, c->direction_o, f->friction);
        f->friction[3] = c->p_r;
        ecp_i_set3(1 / c->e_t, 1 / c->e_o, c->e_r > 0 ? 1 / c->e_r : ECP_R(0), f->weigh);
        ecp_i_set3(c->p_t * f->weigh[0], c->p_o * f->weigh[1], c->p_r * f->weigh[2], y);
        f->y[0] = ecp_i_norm(y) / c->mu;
    }
    return count;
}

static int ecp_i_same_pair(const ecp_i_phase *f, const ecp_i_phase *g)
{
    return f->shape_a == g->shape_a && f->shape_b == g->shape_b;
}

static const ecp_i_phase *ecp_i_find_phase(const ecp_i_phase *list, int count, const ecp_i_phase *f)
{
    int i;
    for (i = 0; i < count; i++) {
        if (ecp_i_same_pair(list + i, f)) return list + i;
    }
    return NULL;
}

static int ecp_i_same_faces(const ecp_i_phase *f, const ecp_i_phase *g)
{
    return f->faces[0] == g->faces[0] && f->faces[1] == g->faces[1];
}

/* has friction turned round? */
static int ecp_i_reversed(const ecp_i_phase *f, const ecp_i_phase *g)
{
    return f->mode == ECP_SLIP && g->mode == ECP_SLIP &&
           ecp_i_dot(f->friction, g->friction) +
                   f->friction[3] * f->weigh[2] * g->friction[3] * g->weigh[2] <
               0;
}

/* ---- what the state at the beginning says to a phase */

/* the velocity of A over B at the point r (from A's centre of mass) at the beginning */
static void ecp_i_slip_at(const ecp_real *va, const ecp_real *vb, const ecp_real r[3],
                          const ecp_real apart[3], ecp_real v[3])
{
    ecp_real rb[3];
    ecp_i_add(apart, r, rb);
    ecp_i_relative_velocity(va, vb, r, rb, v);
}

/* How far the unit vector n (in the primitive's frame) is from the cone of the gradients, at x, of
   the faces that are on: zero if the patch can be what it is at this pose. */
static ecp_real ecp_i_cone_miss(const ecp_i_advance *a, const ecp_shape *shape, const ecp_real x[3],
                                uint64_t faces, const ecp_real n[3])
{
    ecp_real *f = a->values, *g = f + shape->inequalities, rest[3], size = 1;
    int i, k, sweep;
    shape->cls->eval(shape, x, f, g);
    ecp_i_copy3(n, rest);
    /* coordinate descent on the multipliers, which take the place of f */
    for (i = 0; i < shape->inequalities; i++) f[i] = 0;
    for (sweep = 0; sweep < 100; sweep++) {
        ecp_real before = size;
        for (i = 0; i < shape->inequalities; i++) {
            const ecp_real *gi = g + 3 * i;
            ecp_real next, gg = ecp_i_dot(gi, gi);
            if (!(faces >> (i % 64) & 1) || !(gg > 0)) continue;
            next = ecp_i_max(0, f[i] + ecp_i_dot(gi, rest) / gg);
            for (k = 0; k < 3; k++) rest[k] += (f[i] - next) * gi[k];
            f[i] = next;
        }
        size = ecp_i_norm(rest);
        if (!(size < before * ECP_R(0.999))) break;
    }
    return size;
}

static ecp_real ecp_i_speed_scale(const ecp_i_advance *a, const ecp_i_body *b)
{
    ecp_real s = ecp_i_sqrt(a->push * b->length);
    s = ecp_i_max(s, ecp_i_norm(b->v));
    return ecp_i_max(s, b->length * ecp_i_norm(b->v + 3));
}

/* notes when the patch f, in this mode, is ahead, if nothing is sooner */
static void ecp_i_note_ahead(ecp_i_advance *a, const ecp_i_phase *f, ecp_mode mode, ecp_real time,
                             int exact)
{
    if (!(time < a->nearest)) return;
    a->nearest = time;
    a->looking = 1;
    a->exact = exact;
    if (f != &a->ahead) ECPSIM_MEMCPY(&a->ahead, f, sizeof *f);
    a->ahead.mode = mode;
}

/* the time in which d is gone at the speed v that grows by acc, also in one base step; noted if it is
   the shortest */
static void ecp_i_note_time(ecp_i_advance *a, const ecp_i_phase *f, ecp_real d, ecp_real v,
                            ecp_real acc)
{
    ecp_real root = ecp_i_sqrt(v * v + 4 * ecp_i_abs(acc) * d);
    if (v + root > 0) ecp_i_note_ahead(a, f, f->mode, 2 * d / (v + root), 0);
}

/* The gap of the patch in that world, and where: n from A into B, the point from A's centre of mass, and
   its velocity over B. */
static ecp_real ecp_i_gap_at_first(const ecp_world *w, const ecp_i_phase *f, ecp_real n[3],
                                   ecp_real at[3], ecp_real v[3])
{
    const ecp_i_body *ba = ecp_i_body_of(w, f->shape_a), *bb = ecp_i_body_of(w, f->shape_b);
    ecp_real at_b[3], apart[3], gap;
    ecp_i_posed A, B;
    ecp_i_pose_of(w, f->shape_a, ba->x, &A);
    ecp_i_pose_of(w, f->shape_b, ba->x, &B);
    if (B.shape->kind == ECP_HALF_SPACE) {
        gap = ecp_i_plane_gap(&A, &B, 0, n, at);
    } else {
        ecp_i_scale(-1, f->N, n);
        gap = ecp_i_distance(&A, &B, at, at_b, n);
        if (gap > 0) gap = ecp_i_max(gap * ECP_R(0.999), ecp_i_separation(&A, &B, n));
    }
    ecp_i_sub(ba->x, bb->x, apart);
    ecp_i_slip_at(ba->v, bb->v, at, apart, v);
    return gap;
}

/* Can the patch be in this phase at the beginning of the macro step? Returns 1 if its geometry can:
   no gap, no tilt. Otherwise the time until then is noted. */
static int ecp_i_phase_fits(ecp_i_advance *a, const ecp_i_phase *f)
{
    const ecp_world *w = ecp_i_snapshot(a->saved);
    const ecp_i_body *ba = ecp_i_body_of(w, f->shape_a), *bb = ecp_i_body_of(w, f->shape_b);
    const ecp_real *ra = a->rate + 6 * (ba - ecp_i_bodies(w)),
                   *rb = a->rate + 6 * (bb - ecp_i_bodies(w));
    ecp_real at[3], n[3], local[3], v[3], tilt, spin[3], acc;
    ecp_real limit = a->o.tolerance * ecp_i_giving(ba, bb)->length;
    ecp_real gap = ecp_i_gap_at_first(w, f, n, at, v);
    ecp_i_posed A;
    int fits = 1;
    ecp_i_sub(ba->v + 3, bb->v + 3, spin);
    if (gap > limit) {
        /* at the speed of approach, which weight, turning and the last rate of change can raise */
        acc = ecp_i_norm(w->desc.gravity) + ecp_i_norm(ra) + ecp_i_norm(rb) +
              (ecp_i_norm(ra + 3) + ecp_i_dot(ba->v + 3, ba->v + 3)) * ecp_i_norm(at);
        ecp_i_note_time(a, f, gap, ecp_i_dot(n, v), acc);
        fits = 0;
    }
    ecp_i_pose_of(w, f->shape_a, ba->x, &A);
    ecp_i_mul_t(A.Q, n, local);
    tilt = ecp_i_cone_miss(a, A.shape, f->a, f->faces[0], local);
    /* (as far as ecp_i_distance knows a normal) */
    if (ecp_i_parts(w)[f->shape_b].shape.kind != ECP_HALF_SPACE)
        tilt = ecp_i_max(0, tilt - 8 * ecp_i_sqrt(ECP_I_EPSILON));
    if (tilt * A.shape->radius > limit && A.shape->inequalities > 1) {
        ecp_real turn = ecp_i_norm(spin);
        ecp_i_note_time(a, f, tilt, turn, ECP_R(1.5) * (ecp_i_norm(ra + 3) + ecp_i_norm(rb + 3)));
        fits = 0;
    }
    return fits;
}

/* Is a contact with these faces on somewhere on a face, an edge or a line of the primitive, where forces say and not
   the pose? */
static int ecp_i_wanders(const ecp_shape *shape, uint64_t faces)
{
    int on = 0;
    if (shape->kind == ECP_SPHERE || shape->kind == ECP_ELLIPSOID) return 0;
    for (; faces; faces &= faces - 1) on++;
    return on < (shape->cls->hess ? 2 : 3);
}

/* Where the contact of a primitive with a half-space is, and the gap there: the ECP where all faces are
   flat, or else the lowest point. *at: from the origin of the poses; n: into the half-space. */
static ecp_real ecp_i_place(const ecp_i_posed *A, const ecp_i_posed *B, const ecp_real a[3],
                            ecp_real n[3], ecp_real at[3])
{
    ecp_real gap = ecp_i_plane_gap(A, B, 0, n, at), rel[3];
    if (A->shape->kind != ECP_BOX && A->shape->kind != ECP_POLYTOPE) return gap;
    ecp_i_mul(A->Q, a, at);
    ecp_i_add(at, A->x, at);
    ecp_i_sub(at, B->x, rel);
    return -ecp_i_dot(n, rel) - B->shape->size[3];
}

/* How fast that place moves about A's centre of mass as A turns: with A where A is on a corner, not at all where it is
   on a ball. */
static void ecp_i_place_rate(const ecp_i_body *b, const ecp_i_part *part, const ecp_i_posed *B,
                             const ecp_real a[3], const ecp_real at[3], ecp_real rate[3])
{
    ecp_real spin = ecp_i_norm(b->v + 3), time, q[4], n[3], none[3] = {0, 0, 0};
    ecp_i_posed A;
    ecp_i_set3(0, 0, 0, rate);
    if (!(spin > 0)) return;
    time = ecp_i_sqrt(ECP_I_EPSILON) / spin;
    ecp_quat_advance(b->q, b->v + 3, time, q);
    ecp_i_pose_part(part, q, none, &A);
    ecp_i_place(&A, B, a, n, rate);
    ecp_i_sub(rate, at, rate);
    ecp_i_scale(1 / time, rate, rate);
    /* (where a rim lies flat, any of its points is the lowest) */
    if (ecp_i_norm(rate) > 2 * spin * ecp_i_norm(at)) ecp_i_cross(b->v + 3, at, rate);
}

/* Does the patch stick from the beginning because nothing slips there, or because the normal impulse
   of an impact lets it (the part of it that does not shrink with the base step)? */
static int ecp_i_stick_fits(ecp_i_advance *a, const ecp_i_phase *f)
{
    const ecp_world *w = ecp_i_snapshot(a->saved);
    const ecp_i_body *ba = ecp_i_body_of(w, f->shape_a), *bb = ecp_i_body_of(w, f->shape_b);
    const ecp_real *ra = a->rate + 6 * (ba - ecp_i_bodies(w)),
                   *rb = a->rate + 6 * (bb - ecp_i_bodies(w));
    const ecp_i_body *b = ecp_i_giving(ba, bb);
    ecp_real at[3], n[3], v[3], slow[3], apart[3], move[3], size, closing, turn, impulse;
    ecp_i_posed A, B;
    int exact;
    ecp_i_pose_of(w, f->shape_a, ba->x, &A);
    ecp_i_pose_of(w, f->shape_b, ba->x, &B);
    ecp_i_sub(ba->x, bb->x, apart);
    exact = B.shape->kind == ECP_HALF_SPACE && bb->kind == ECP_STATIC &&
            (f->weigh[2] > 0 || !ecp_i_wanders(A.shape, f->faces[0]));
    if (B.shape->kind == ECP_HALF_SPACE) {
        ecp_i_place(&A, &B, f->a, n, at);
        ecp_i_place_rate(ba, ecp_i_parts(w) + f->shape_a, &B, f->a, at, move);
    } else {
        ecp_i_mul(A.Q, f->a, at);
        ecp_i_add(at, A.x, at);
        ecp_i_set3(0, 0, 0, move);
    }
    ecp_i_slip_at(ba->v, bb->v, at, apart, v);
    ecp_i_slip_at(ra, rb, at, apart, slow);
    ecp_i_add_cross(ba->v + 3, move, slow);
    ecp_i_axpy(v, -ecp_i_dot(v, f->N), f->N, v);
    ecp_i_axpy(slow, -ecp_i_dot(slow, f->N), f->N, slow);
    size = ecp_i_dot(v, v);
    closing = -ecp_i_dot(v, slow);
    if (f->weigh[2] > 0) {
        /* torsion stops the spin as well */
        turn = ecp_i_dot(f->N, ba->v + 3) - ecp_i_dot(f->N, bb->v + 3);
        size += b->length * turn * b->length * turn;
        closing -=
            b->length * turn * b->length * (ecp_i_dot(f->N, ra + 3) - ecp_i_dot(f->N, rb + 3));
    }
    size = ecp_i_sqrt(size);
    if (size <= a->o.tolerance * ecp_i_speed_scale(a, b)) return 1;
    impulse = 2 * f->p_n[1] - f->p_n[0];
    if (f->y[1] < ECP_R(0.98) * impulse) return 1;
    /* until it stops, or nearly so */
    if (closing > 0) {
        ecp_real time = size * size / closing;
        if (!exact || time > a->drift) {
            /* not quite: base steps that reach beyond it end the macro step. What is left should be long enough for
               another one, or short enough to drift. */
            int much = time > a->H / 8 || (exact && time > 1000 * a->drift);
            time *= much ? ECP_R(0.98) : ECP_R(0.999);
        }
        ecp_i_note_ahead(a, f, ECP_STICK, time, exact);
    }
    return 0;
}

/* does the patch slip at the beginning, against the friction that it is to have? */
static int ecp_i_slip_fits(const ecp_i_advance *a, const ecp_i_phase *f)
{
    const ecp_world *w = ecp_i_snapshot(a->saved);
    const ecp_i_body *ba = ecp_i_body_of(w, f->shape_a), *bb = ecp_i_body_of(w, f->shape_b);
    const ecp_i_body *b = ecp_i_giving(ba, bb);
    ecp_real at[3], v[3], apart[3], spin[3], along, size;
    ecp_i_posed A;
    ecp_i_pose_of(w, f->shape_a, ba->x, &A);
    ecp_i_mul(A.Q, f->a, at);
    ecp_i_add(at, A.x, at);
    ecp_i_sub(ba->x, bb->x, apart);
    ecp_i_slip_at(ba->v, bb->v, at, apart, v);
    ecp_i_axpy(v, -ecp_i_dot(v, f->N), f->N, v);
    ecp_i_sub(ba->v + 3, bb->v + 3, spin);
    along = ecp_i_dot(f->friction, v) + f->friction[3] * ecp_i_dot(f->N, spin);
    size = ecp_i_max(ecp_i_norm(v), b->length * ecp_i_abs(ecp_i_dot(f->N, spin)));
    if (f->y[0] == 0) return 1; /* no friction, no stick */
    return along < 0 && size > a->o.tolerance * ecp_i_speed_scale(a, b);
}

/* A phase is over, without a jump. Either it ends where the macro step begins, and that must be a
   brief one to show it; or, where there still is a margin, later. */
static void ecp_i_gone(ecp_i_advance *a, int later)
{
    if (later)
        a->changed = 1;
    else
        a->brief = 1;
}

/* Compares the phases of the macro step, which are the same in all base steps, with those before and
   with the state at its beginning. */
static void ecp_i_check_beginning(ecp_i_advance *a)
{
    ecp_real load = 0, few = ECP_R(1e-4);
    int i;
    for (i = 0; i < a->last_count; i++) load = ecp_i_max(load, a->last[i].margin[0]);
    for (i = 0; i < a->now_count; i++) {
        const ecp_i_phase *f = a->now + i;
        const ecp_i_phase *before = ecp_i_find_phase(a->last, a->last_count, f);
        int known = before && ecp_i_same_faces(before, f);
        if (!known) {
            a->impact = 1;
            if (!ecp_i_phase_fits(a, f)) a->changed = 1;
            /* a face that turns into an edge does so without a jump */
            if (before && (before->faces[0] & ~f->faces[0]) == 0 &&
                (before->faces[1] & ~f->faces[1]) == 0) {
                ecp_i_gone(a, before->margin[2] > few * ecp_i_phase_radius(a->w, f));
            }
        }
        if (f->mode == ECP_STICK) {
            if ((!before || before->mode != ECP_STICK) && !ecp_i_stick_fits(a, f)) a->changed = 1;
            if (before && before->mode != ECP_STICK) a->impact = 1;
        } else {
            if (before && before->mode == ECP_SLIP && known) {
                if (ecp_i_reversed(before, f)) a->brief = 1;
            } else if (!ecp_i_slip_fits(a, f)) {
                ecp_i_gone(a, known && before->margin[1] > few * before->mu * load);
            }
        }
    }
    for (i = 0; i < a->last_count; i++) {
        if (ecp_i_find_phase(a->now, a->now_count, a->last + i)) continue;
        ecp_i_gone(a, a->last[i].margin[0] > few * load);
    }
}

/* After the base step i of the column j: are the phases those of the first? */
static void ecp_i_compare_phases(ecp_i_advance *a, int column, int i, ecp_i_phase *list, int count)
{
    int k;
    if (column == 1) return;
    if (count != a->now_count) a->changed = 1;
    for (k = 0; k < count && !a->changed; k++) {
        ecp_i_phase *f = a->now + k, *g = list + k;
        if (!ecp_i_same_pair(f, g) || !ecp_i_same_faces(f, g) || f->mode != g->mode ||
            ecp_i_reversed(f, g)) {
            a->changed = 1;
            break;
        }
        if (column == 2 && i == 0) {
            f->p_n[1] = g->p_n[0];
            f->y[1] = g->y[0];
        }
    }
    /* what was not there before: how long until it can be? */
    for (k = 0; k < count && a->changed; k++) {
        const ecp_i_phase *g = list + k, *before = ecp_i_find_phase(a->last, a->last_count, g);
        if (!before || !ecp_i_same_faces(before, g)) ecp_i_phase_fits(a, g);
        if (before && before->mode == ECP_SLIP &&
            (g->mode == ECP_STICK || ecp_i_reversed(before, g))) {
            ecp_i_stick_fits(a, g);
        }
    }
}

/* how far the point x of a primitive, which is on these faces, is from the others, but no more than `most` */
static ecp_real ecp_i_rim_margin(const ecp_i_advance *a, const ecp_shape *shape, uint64_t faces,
                                 const ecp_real x[3], ecp_real most)
{
    int i;
    shape->cls->eval(shape, x, a->values, NULL);
    for (i = 0; i < shape->inequalities; i++) {
        if (!(faces >> (i % 64) & 1)) most = ecp_i_min(most, -a->values[i]);
    }
    return most;
}

/* The margins of a patch that carries these forces, with the ECP there: of the load, of friction that
   sticks, and of the ECP from the rims of both; negative where the phase is over. */
static void ecp_i_margins(const ecp_i_advance *a, const ecp_i_phase *f, const ecp_real *row,
                          ecp_real margin[3])
{
    const ecp_shape *sa = &ecp_i_parts(a->w)[f->shape_a].shape;
    const ecp_shape *sb = &ecp_i_parts(a->w)[f->shape_b].shape;
    ecp_real y[3];
    int i;
    for (i = 0; i < 3; i++) y[i] = row[1 + i] * f->weigh[i];
    margin[0] = row[0];
    margin[1] = f->mode == ECP_STICK ? f->mu * row[0] - ecp_i_norm(y) : ECP_R(1.0);
    margin[2] = ecp_i_rim_margin(a, sa, f->faces[0], row + 4, sa->radius);
    if (ECP_I_PAIRS && sb->kind != ECP_HALF_SPACE)
        margin[2] = ecp_i_rim_margin(a, sb, f->faces[1], row + 7, margin[2]);
}

/* Base steps see the end of a phase late, by a time of the order of their length. The extrapolated
   forces do not: is the phase over at the end of the macro step for them? */
static int ecp_i_outlived(ecp_i_advance *a)
{
    const ecp_real *row = a->rows + 12 * a->w->bodies;
    ecp_real load = 0, tiny = ECP_R(1e-6), margin[3];
    int k, over = 0;
    for (k = 0; k < a->now_count; k++) load = ecp_i_max(load, row[ECP_I_FORCES * k]);
    for (k = 0; k < a->now_count; k++) {
        const ecp_i_phase *f = a->now + k;
        ecp_i_margins(a, f, row + ECP_I_FORCES * k, margin);
        over |= margin[0] < -tiny * load;
        over |= margin[1] < -tiny * f->mu * load;
        over |= margin[2] < -tiny * ecp_i_phase_radius(a->w, f);
    }
    return over;
}

/* the time in which a margin is gone, at its rate; the shortest of all patches */
static ecp_real ecp_i_margin_time(const ecp_i_advance *a)
{
    ecp_real time = ECP_I_NEVER;
    int k, m;
    for (k = 0; k < a->last_count; k++) {
        const ecp_i_phase *f = a->last + k;
        for (m = 0; m < 3; m++) {
            if (f->rate[m] < 0 && f->margin[m] > 0)
                time = ecp_i_min(time, -f->margin[m] / f->rate[m]);
        }
    }
    return time;
}

/* ---- macro steps */

/* the angular velocity by an angular impulse L, by way of the body's axes: in the world's a needle would lose the spin
   about itself */
static void ecp_i_spin_change(const ecp_i_body *b, ecp_real L[3])
{
    ecp_real R[9], own[3];
    ecp_quat_to_matrix(b->q, R);
    ecp_i_mul_t(R, L, own);
    ecp_i_solve3(b->inertia, own);
    ecp_i_mul(R, own, L);
}

/* An impulse J on the body b at r from its centre of mass, along the directions d[0..n): the one that
   makes the velocity v of that point zero in these directions. */
static void ecp_i_stop_point(ecp_i_body *b, const ecp_real r[3], int n, const ecp_real *d,
                             const ecp_real v[3])
{
    ecp_real K[9], x[3], turn[9], arm[3];
    int i, j, k;
    for (i = 0; i < n; i++) {
        ecp_i_cross(r, d + 3 * i, turn + 3 * i);
        ecp_i_spin_change(b, turn + 3 * i);
        x[i] = -ecp_i_dot(d + 3 * i, v);
    }
    for (i = 0; i < n; i++) {
        ecp_i_cross(r, d + 3 * i, arm);
        for (j = 0; j < n; j++) {
            K[3 * i + j] = ecp_i_dot(arm, turn + 3 * j) + ecp_i_dot(d + 3 * i, d + 3 * j) / b->mass;
        }
    }
    if (ecp_chol_factor(n, K, 3)) return;
    ecp_chol_solve(n, K, 3, x);
    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) {
            ecp_i_add_carried(b->v + k, b->v_carry + k, x[i] * d[3 * i + k] / b->mass);
            ecp_i_add_carried(b->v + 3 + k, b->v_carry + 3 + k, x[i] * turn[3 * i + k]);
        }
    }
}

/* a body's changes over the macro step: displacement, Cayley vector of the turn, velocity */
static void ecp_i_changes(const ecp_i_body *b, const ecp_i_body *before, ecp_real row[12])
{
    ecp_real back[4], turn[4], q[4];
    int k;
    for (k = 0; k < 3; k++)
        row[k] = (b->x[k] - before->x[k]) + (b->x_carry[k] - before->x_carry[k]);
    back[0] = before->q[0];
    ecp_i_scale(-1, before->q + 1, back + 1);
    /* by differences, so that what does not turn has no turn at all */
    for (k = 0; k < 4; k++) q[k] = (b->q[k] - before->q[k]) + (b->q_carry[k] - before->q_carry[k]);
    ecp_quat_multiply(q, back, turn);
    turn[0] += 1;
    ecp_i_scale(1 / turn[0], turn + 1, row + 3);
    for (k = 0; k < 6; k++) {
        row[6 + k] = (b->v[k] - before->v[k]) + (b->v_carry[k] - before->v_carry[k]);
    }
}

static int ecp_i_moves(const ecp_i_body *b)
{
    return b->kind == ECP_DYNAMIC || b->kind == ECP_KINEMATIC;
}

/* the forces of the beginning, and the callback's at the time t */
static void ecp_i_load_at(const ecp_i_advance *a, ecp_real t)
{
    const ecp_i_body *first = ecp_i_bodies(ecp_i_snapshot(a->first));
    ecp_i_body *b = ecp_i_bodies(a->w);
    int i;
    for (i = 0; i < a->w->bodies; i++) ECPSIM_MEMCPY(b[i].force, first[i].force, sizeof b[i].force);
    if (a->o.load) a->o.load(a->o.load_user, a->w, a->o.time + t);
}

/* rate_now = keep rate_now + s v, for all bodies */
static void ecp_i_rates(ecp_i_advance *a, ecp_real keep, ecp_real s)
{
    const ecp_i_body *b = ecp_i_bodies(a->w);
    ecp_real *out = a->rate_now;
    int i, k;
    for (i = 0; i < a->w->bodies; i++) {
        for (k = 0; k < 6; k++) {
            out[6 * i + k] = keep * out[6 * i + k] + s * (b[i].v[k] + b[i].v_carry[k]);
        }
    }
}

/* forces and ECPs of the patches that carry, of a base step of the length h */
static void ecp_i_forces(const ecp_world *w, ecp_real h, ecp_real *row)
{
    int i;
    for (i = 0; i < w->patches; i++) {
        const ecp_i_patch *p = ecp_i_patches(w) + i;
        if (p->guess || p->contact.mode == ECP_APART) continue;
        row[0] = p->contact.p_n / h;
        row[1] = p->contact.p_t / h;
        row[2] = p->contact.p_o / h;
        row[3] = p->contact.p_r / h;
        ecp_i_copy3(p->a, row + 4);
        if (ECP_I_PAIRS) ecp_i_ecp_on_b(w, &p->contact, row + 7);
        row += ECP_I_FORCES;
    }
}

/* The gap of a patch on a half-space at rest, a time s from now (s < 0: ago) if its body has the velocities all the while
   that it has now. n points into the half-space, `at` is the contact from the body's centre of mass then. */
static ecp_real ecp_i_gap_after(const ecp_world *w, const ecp_i_phase *f, ecp_real s, ecp_real n[3],
                                ecp_real at[3], ecp_real *rounding)
{
    const ecp_i_part *part = ecp_i_parts(w) + f->shape_a;
    const ecp_i_body *b = ecp_i_bodies(w) + part->body;
    const ecp_real none[3] = {0, 0, 0};
    ecp_real q[4], gap;
    ecp_i_posed A, B;
    ecp_quat_advance(b->q, b->v + 3, s, q);
    ecp_i_pose_part(part, q, none, &A);
    ecp_i_pose_of(w, f->shape_b, b->x, &B);
    ecp_i_axpy(B.x, -s, b->v, B.x);
    gap = ecp_i_place(&A, &B, f->a, n, at);
    *rounding = 32 * ECP_I_EPSILON * (ecp_i_norm(B.x) + ecp_i_norm(at));
    return gap;
}

/* Which way the columns of this macro step take their lead-in, and which patches are without. What a contact on a curve
   leaves of a gap is of the second order in H, back as ahead. Where one of them is of the first, another part of the
   primitive has carried, or will: a table that has just tipped on to a rim, a disc that falls flat. */
static void ecp_i_lead_which_way(ecp_i_advance *a)
{
    ecp_world *w = a->w;
    ecp_real n[3], at[3], rounding;
    int i;
    a->lead = -1;
    for (i = 0; i < a->last_count; i++) {
        ecp_i_phase *f = a->last + i;
        ecp_real back, ahead;
        f->no_lead = ecp_i_parts(w)[f->shape_b].shape.kind != ECP_HALF_SPACE ||
                     ecp_i_body_of(w, f->shape_b)->kind != ECP_STATIC;
        if (f->no_lead) continue;
        back = ecp_i_abs(ecp_i_gap_after(w, f, -a->H, n, at, &rounding));
        ahead = ecp_i_abs(ecp_i_gap_after(w, f, a->H, n, at, &rounding));
        if (back > 2 * ahead + rounding) a->lead = 1;
    }
    for (i = 0; i < a->last_count; i++) {
        ecp_i_phase *f = a->last + i;
        const ecp_i_body *b = ecp_i_body_of(w, f->shape_a);
        ecp_real turn = a->H * ecp_i_norm(b->v + 3), gap, least;
        if (f->no_lead) continue;
        gap = ecp_i_gap_after(w, f, a->lead * a->H, n, at, &rounding);
        least = a->H * a->o.tolerance * ecp_i_speed_scale(a, b);
        f->no_lead = ecp_i_abs(gap) > 16 * turn * turn * b->length + least;
    }
}

/* A base step of the length h ends with its gaps closed, so it begins, but for a column's first one, with the velocity
   of a way from closed gaps to closed gaps. From velocities that keep them closed at the instant the first one would
   have another force than those that follow, by a half of what the contact's curve takes (an edge that a body turns
   about), whatever h, and friction follows that force. So a column begins with velocities whose way back closes the
   gaps: they differ from the state's in proportion to h. (With those whose way ahead does, the first force is without
   the curve: a body that spins fast was free in each first base step, as that is what holds it down.) Sideways what
   sticks has no other velocity than before. Where another part of the primitive has carried on the way back, the
   difference is taken from the way ahead, the other way round. */
static void ecp_i_lead_in(ecp_i_advance *a, ecp_real h)
{
    ecp_world *w = a->w;
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    ecp_real d[9], at[3], v[3], s, rounding, worst = 1;
    int sweep, i, k;
    if (h >= a->H) ecp_i_lead_which_way(a);
    s = a->lead * h;
    for (sweep = 0; sweep < 10 && worst > 4 * ECP_I_EPSILON; sweep++) {
        for (i = 0, worst = 0; i < a->last_count; i++) {
            const ecp_i_phase *f = a->last + i;
            ecp_i_body *b = ecp_i_bodies(w) + ecp_i_parts(w)[f->shape_a].body;
            ecp_real gap;
            if (f->no_lead) continue;
            gap = ecp_i_gap_after(w, f, s, d, at, &rounding);
            if (ecp_i_abs(gap) <= rounding) continue;
            ecp_i_plane_axes(d, d + 3, d + 6);
            ecp_i_scale(-gap / s, d, v);
            ecp_i_stop_point(b, at, f->mode == ECP_STICK ? 3 : 1, d, v);
            worst = ecp_i_max(worst, ecp_i_abs(gap / s) / ecp_i_speed_scale(a, b));
        }
    }
    for (i = 0; a->lead > 0 && i < w->bodies; i++) {
        ecp_i_body *b = ecp_i_bodies(w) + i;
        for (k = 0; k < 6; k++) {
            ecp_real by = (before[i].v[k] - b->v[k]) + (before[i].v_carry[k] - b->v_carry[k]);
            ecp_i_add_carried(b->v + k, b->v_carry + k, 2 * by);
        }
    }
}

static void ecp_i_clear_report(ecp_report *r)
{
    ECPSIM_MEMSET(r, 0, sizeof *r);
    ecp_i_clear_failure(r);
    r->substeps = 1;
}

/* Column j: j base steps from the saved state. Its changes become row j - 1 of the tableau. */
static ecp_status ecp_i_macro_column(ecp_i_advance *a, int column)
{
    ecp_world *w = a->w;
    ecp_real h = a->H / (ecp_real)column, *row = a->rows + (column - 1) * a->row;
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    int i, count;
    ECPSIM_MEMCPY(w, a->saved, w->state_bytes);
    ecp_i_lead_in(a, h);
    for (i = 0; i < column; i++) {
        ecp_status status;
        ecp_i_phase *list = column == 1 ? a->now : a->here;
        ecp_i_load_at(a, a->t + (ecp_real)(i + 1) * h);
        if (i == column - 1) ecp_i_rates(a, 0, -1 / h);
        ecp_i_clear_report(&a->r->step);
        status = ecp_i_step_once(w, h, &a->step, a->bytes, NULL, &a->r->step);
        a->r->solves++;
        a->r->step.status = status;
        if (status != ECP_OK) return status;
        count = ecp_i_phases(a, list);
        if (column == 1) a->now_count = count;
        ecp_i_compare_phases(a, column, i, list, count);
    }
    for (i = 0; i < w->bodies; i++) {
        if (ecp_i_moves(before + i)) ecp_i_changes(ecp_i_bodies(w) + i, before + i, row + 12 * i);
    }
    ecp_i_rates(a, 1, 1 / h);
    if (!a->changed) ecp_i_forces(w, h, row + 12 * w->bodies);
    return ECP_OK;
}

/* Row j of the tableau after the rows above it: Aitken-Neville in place. Row i holds T_{j,j-i} on
   return, row 0 thus T_jj; the column with base steps H / j comes in row j - 1. */
static void ecp_i_extrapolate(ecp_i_advance *a, int j)
{
    int i, k, n = 12 * a->w->bodies + ECP_I_FORCES * a->now_count;
    for (i = j - 2; i >= 0; i--) {
        ecp_real *to = a->rows + i * a->row;
        const ecp_real *from = to + a->row;
        ecp_real factor = (ecp_real)j / (ecp_real)(i + 1) - 1;
        for (k = 0; k < n; k++) to[k] = from[k] + (from[k] - to[k]) / factor;
    }
}

/* driven bodies have no length of their own: the shortest of the others', or 1 m if there is none */
static ecp_real ecp_i_shortest_length(const ecp_i_advance *a)
{
    ecp_real shortest = 0;
    int i;
    for (i = 0; i < a->w->bodies; i++) {
        ecp_real length = ecp_i_bodies(a->w)[i].length;
        if (length > 0 && (shortest == 0 || length < shortest)) shortest = length;
    }
    return shortest > 0 ? shortest : ECP_R(1.0);
}

/* the difference of two rows of changes, in tolerances */
static ecp_real ecp_i_error(const ecp_i_advance *a, const ecp_real *p, const ecp_real *q)
{
    const ecp_i_body *b = ecp_i_bodies(ecp_i_snapshot(a->saved));
    ecp_real worst = 0, d[12], shortest = ecp_i_shortest_length(a);
    int i, k;
    for (i = 0; i < a->w->bodies; i++) {
        ecp_i_body end = b[i];
        ecp_real speed;
        if (!ecp_i_moves(b + i)) continue;
        for (k = 0; k < 12; k++) d[k] = p[12 * i + k] - q[12 * i + k];
        ecp_i_worst(&worst, ecp_i_norm(d) / (b[i].kind == ECP_DYNAMIC ? b[i].length : shortest));
        ecp_i_worst(&worst, 2 * ecp_i_norm(d + 3));
        if (b[i].kind != ECP_DYNAMIC) continue;
        for (k = 0; k < 6; k++) end.v[k] += p[12 * i + 6 + k];
        speed = ecp_i_max(ecp_i_speed_scale(a, b + i), ecp_i_speed_scale(a, &end));
        if (!(speed > 0)) continue;
        ecp_i_worst(&worst, ecp_i_norm(d + 6) / speed);
        ecp_i_worst(&worst, ecp_i_norm(d + 9) * b[i].length / speed);
    }
    return worst / a->o.tolerance;
}

/* What can be hidden in the macro step where the phases change: the change of velocity for all of
   its time, in tolerances. */
static ecp_real ecp_i_hidden(const ecp_i_advance *a, const ecp_real *row)
{
    const ecp_i_body *b = ecp_i_bodies(ecp_i_snapshot(a->saved));
    ecp_real worst = 0;
    int i;
    for (i = 0; i < a->w->bodies; i++) {
        if (b[i].kind != ECP_DYNAMIC) continue;
        ecp_i_worst(&worst, ecp_i_norm(row + 12 * i + 6) / b[i].length);
        ecp_i_worst(&worst, ecp_i_norm(row + 12 * i + 9));
    }
    return worst * a->H / a->o.tolerance;
}

/* the saved state and the extrapolated changes, in the world, whose patches are of the last base step */
static void ecp_i_add_changes(ecp_i_advance *a)
{
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    const ecp_real *row = a->rows;
    ecp_i_body *b = ecp_i_bodies(a->w);
    int i, k;
    for (i = 0; i < a->w->bodies; i++, row += 12) {
        if (!ecp_i_moves(before + i)) continue;
        ECPSIM_MEMCPY(b + i, before + i, sizeof *b);
        for (k = 0; k < 3; k++) ecp_i_add_carried(b[i].x + k, b[i].x_carry + k, row[k]);
        ecp_i_turn_carried(b + i, row + 3);
        for (k = 0; k < 6; k++) ecp_i_add_carried(b[i].v + k, b[i].v_carry + k, row[6 + k]);
    }
}

/* The normal n of two primitives, out of A, at these poses, from one before: if it shows more of their distance. Along
   one that is off by an angle they seem to overlap by half its square of their size, and to press there moves them
   aside. */
static void ecp_i_renew_normal(const ecp_i_posed *A, const ecp_i_posed *B, ecp_real n[3])
{
    ecp_real now[3], at_a[3], at_b[3];
    ecp_i_copy3(n, now);
    if (!(ecp_i_distance(A, B, at_a, at_b, now) > 0)) ecp_i_overlap(A, B, now);
    if (ecp_i_dot(now, n) > ECP_R(0.5) && ecp_i_separation(A, B, now) > ecp_i_separation(A, B, n))
        ecp_i_copy3(now, n);
}

/* Gaps, normals and points of the contacts at the pose of the world. Returns the largest violation: overlap, or
   a gap under load, beyond its rounding error. */
static ecp_real ecp_i_refresh_contacts(ecp_i_advance *a)
{
    ecp_world *w = a->w;
    ecp_real worst = 0;
    int i;
    for (i = 0; i < w->patches; i++) {
        ecp_contact *c = &ecp_i_patches(w)[i].contact;
        const ecp_i_body *ba = ecp_i_body_of(w, c->shape_a), *bb = ecp_i_body_of(w, c->shape_b);
        ecp_real n[3], at[3], x[3], limit, gap;
        ecp_i_posed A, B;
        if (ecp_i_patches(w)[i].guess) continue;
        ecp_i_pose_of(w, c->shape_a, ba->x, &A);
        ecp_i_pose_of(w, c->shape_b, ba->x, &B);
        ecp_i_scale(-1, c->normal, n);
        if (B.shape->kind == ECP_HALF_SPACE) {
            c->separation = ecp_i_plane_gap(&A, &B, 0, n, at);
        } else {
            ecp_i_renew_normal(&A, &B, n);
            c->separation = ecp_i_separation(&A, &B, n);
        }
        ecp_i_scale(-1, n, c->normal);
        ecp_i_mul(A.Q, ecp_i_patches(w)[i].a, at);
        ecp_i_add(at, A.x, at);
        ecp_i_add(at, ba->x, c->point_a);
        c->gap = c->separation;
        ecp_i_axpy(c->point_a, c->gap, n, c->point_b);
        ecp_i_sub(ba->x, bb->x, x);
        limit = ecp_i_norm(x) + ecp_i_norm(at);
        if (B.shape->kind == ECP_HALF_SPACE) limit += ecp_i_abs(B.shape->size[3]);
        limit *= 32 * ECP_I_EPSILON;
        gap = c->mode != ECP_APART ? ecp_i_abs(c->separation) : -c->separation;
        if (gap > limit) ecp_i_worst(&worst, gap);
    }
    return worst;
}

/* Does the patch i stick at a place that its forces move about on A, while A turns there for want of torsion? Then no
   point of A stands still, and where the contact was in the last base step says nothing. */
static int ecp_i_pivots(const ecp_i_advance *a, int i)
{
    const ecp_i_patch *p = ecp_i_patches(a->w) + i;
    const ecp_contact *c = &p->contact;
    const ecp_i_body *b = ecp_i_bodies(a->w) + c->body_a, *ground = ecp_i_bodies(a->w) + c->body_b;
    const ecp_shape *shape = &ecp_i_parts(a->w)[c->shape_a].shape;
    ecp_real turn = ecp_i_dot(c->normal, b->v + 3) - ecp_i_dot(c->normal, ground->v + 3);
    if (c->e_r > 0) return 0;
    if (ecp_i_abs(turn) * b->length <= a->o.tolerance * ecp_i_speed_scale(a, b)) return 0;
    return ecp_i_wanders(shape, ecp_i_faces(a, shape, b->length, p->a, ecp_i_multipliers(a->w, i)));
}

/* Takes off the velocities that patches on half-spaces do not have: along the normal where they carry,
   sideways where they stick. Impulses there do it, the least change in the norm of the kinetic
   energy, which only falls. What is left would be a force in the next base step, the greater the
   shorter that is. */
static void ecp_i_project_velocities(ecp_i_advance *a)
{
    ecp_world *w = a->w;
    int sweep, i;
    for (sweep = 0; sweep < 20; sweep++) {
        int moves = 0;
        for (i = 0; i < w->patches; i++) {
            const ecp_contact *c = &ecp_i_patches(w)[i].contact;
            ecp_i_body *b = ecp_i_bodies(w) + c->body_a;
            const ecp_i_body *ground = ecp_i_bodies(w) + c->body_b;
            ecp_real n[3], at[3], v[3], apart[3], d[9];
            ecp_i_posed A, B;
            int stick;
            if (ecp_i_patches(w)[i].guess || c->mode == ECP_APART) continue;
            ecp_i_pose_of(w, c->shape_a, b->x, &A);
            ecp_i_pose_of(w, c->shape_b, b->x, &B);
            if (B.shape->kind != ECP_HALF_SPACE || b->kind != ECP_DYNAMIC) continue;
            stick = c->mode == ECP_STICK && !ecp_i_pivots(a, i);
            ecp_i_place(&A, &B, ecp_i_patches(w)[i].a, n, at);
            ecp_i_sub(b->x, ground->x, apart);
            ecp_i_slip_at(b->v, ground->v, at, apart, v);
            ecp_i_copy3(n, d);
            ecp_i_copy3(c->direction_t, d + 3);
            ecp_i_cross(n, c->direction_t, d + 6);
            ecp_i_stop_point(b, at, stick ? 3 : 1, d, v);
            if (!stick) ecp_i_scale(ecp_i_dot(n, v), n, v);
            moves |= ecp_i_norm(v) > 4 * ECP_I_EPSILON * ecp_i_speed_scale(a, b);
        }
        if (!moves) return;
    }
}

/* may the two primitives touch, wherever they are? Of a half-space and another one j is the half-space, of others i
   is the first. */
static int ecp_i_can_touch(const ecp_world *w, int i, int j)
{
    const ecp_i_part *a = ecp_i_parts(w) + i, *b = ecp_i_parts(w) + j;
    int plane = b->shape.kind == ECP_HALF_SPACE;
    if (a->shape.kind == ECP_HALF_SPACE || (!plane && (!ECP_I_PAIRS || j <= i))) return 0;
    if (a->body == b->body || !ecp_i_may_meet(a, b)) return 0;
    return ecp_i_body_of(w, i)->kind == ECP_DYNAMIC || ecp_i_body_of(w, j)->kind == ECP_DYNAMIC;
}

/* do any two overlap by more than the rounding of their poses? */
static int ecp_i_overlaps(const ecp_world *w)
{
    int i, j;
    for (i = 0; i < w->shapes; i++) {
        for (j = 0; j < w->shapes; j++) {
            ecp_i_posed A, B;
            ecp_real n[3], at_a[3], depth, size;
            const ecp_i_body *body;
            if (!ecp_i_can_touch(w, i, j)) continue;
            body = ecp_i_body_of(w, i);
            ecp_i_pose_of(w, i, body->x, &A);
            ecp_i_pose_of(w, j, body->x, &B);
            if (B.shape->kind == ECP_HALF_SPACE) {
                depth = -ecp_i_plane_gap(&A, &B, 0, n, at_a);
            } else {
                if (!ecp_i_closer(&A, &B, 0)) continue;
                depth = ecp_i_overlap(&A, &B, n);
            }
            size = ecp_i_norm(body->x) + ecp_i_norm(B.x) + A.shape->radius + ecp_i_norm(A.x);
            if (depth > 64 * ECP_I_EPSILON * size) return 1;
        }
    }
    return 0;
}

/* The step h of the world at rest, without weight, on to which the normal impulses press that the contacts
   have just had, times `press`. Its displacement is the least, in the norm of the kinetic energy, that closes gaps
   and overlaps; of its result the poses are kept, and the normals, which are better than those of nearest points;
   velocities and the rest stay; without `press` the poses do as well if no body moves by more than rounding. What lies
   deep may need shorter steps. Returns whether it is solved. */
static int ecp_i_still_step(ecp_i_advance *a, ecp_real h, ecp_real press)
{
    ecp_world *w = a->w;
    ecp_i_body *b = ecp_i_bodies(w), *kept;
    const ecp_world *before = ecp_i_snapshot(a->saved);
    ecp_real none[3] = {0, 0, 0}, way[3];
    ecp_status status;
    ecp_report quiet;
    int i, k, moved = 0;
    ECPSIM_MEMCPY(a->saved, w, w->state_bytes);
    kept = ecp_i_bodies(before);
    for (i = 0; i < w->bodies; i++) {
        if (!ecp_i_moves(b + i)) continue;
        ECPSIM_MEMSET(b[i].v, 0, sizeof b[i].v);
        ECPSIM_MEMSET(b[i].v_carry, 0, sizeof b[i].v_carry);
        ECPSIM_MEMSET(b[i].force, 0, sizeof b[i].force);
    }
    for (i = 0; press > 0 && i < w->patches; i++) {
        const ecp_contact *c = &ecp_i_patches(w)[i].contact;
        ecp_real p[3];
        if (ecp_i_patches(w)[i].guess || c->mode == ECP_APART) continue;
        ecp_i_scale(-press * c->p_n, c->normal, p);
        ecp_body_apply_impulse(w, c->body_a, p, c->point_a);
        ecp_i_scale(-1, p, p);
        ecp_body_apply_impulse(w, c->body_b, p, c->point_a);
    }
    ecp_i_copy3(none, w->desc.gravity);
    ECPSIM_MEMSET(&quiet, 0, sizeof quiet);
    status = ecp_i_step_once(w, h, &a->step, a->bytes, NULL, &quiet);
    if (status == ECP_NOT_SOLVED && press == 0 && ecp_i_may(&a->step, ECP_FALLBACK_SUBSTEPS))
        status = ecp_i_step_by_parts(w, h, &a->step, a->bytes, 0, &quiet);
    a->r->solves += quiet.substeps > 1 ? quiet.substeps : 1;
    for (i = 0; status == ECP_OK && i < w->bodies; i++) {
        ecp_i_sub(b[i].x, kept[i].x, way);
        moved |= ecp_i_norm(way) > 64 * ECP_I_EPSILON * (b[i].length + ecp_i_norm(b[i].x));
        for (k = 0; k < 4; k++) moved |= ecp_i_abs(b[i].q[k] - kept[i].q[k]) > 64 * ECP_I_EPSILON;
    }
    for (i = 0; status == ECP_OK && i < w->patches && i < before->patches; i++) {
        const ecp_contact *c = &ecp_i_patches(w)[i].contact;
        ecp_contact *to = &ecp_i_patches(before)[i].contact;
        if (c->shape_a == to->shape_a && c->shape_b == to->shape_b)
            ecp_i_copy3(c->normal, to->normal);
    }
    for (i = 0; (moved || press > 0) && status == ECP_OK && i < w->bodies; i++) {
        if (b[i].kind != ECP_DYNAMIC) continue;
        ecp_i_copy3(b[i].x, kept[i].x);
        ecp_i_copy3(b[i].x_carry, kept[i].x_carry);
        ECPSIM_MEMCPY(kept[i].q, b[i].q, sizeof b[i].q);
        ECPSIM_MEMCPY(kept[i].q_carry, b[i].q_carry, sizeof b[i].q_carry);
    }
    ECPSIM_MEMCPY(w, a->saved, w->state_bytes);
    return status == ECP_OK;
}

/* Back on to the contacts. */
static void ecp_i_project(ecp_i_advance *a)
{
    const ecp_world *w = a->w;
    const ecp_i_body *b = ecp_i_bodies(w);
    ecp_real off = ecp_i_refresh_contacts(a), press, most;
    int i, round;
    for (round = 0; round < 3 && off > 0; round++) {
        if (round == 0 && off > a->r->projection) a->r->projection = off;
        for (i = 0, most = 0; i < w->patches; i++) {
            const ecp_contact *c = &ecp_i_patches(w)[i].contact;
            if (ecp_i_patches(w)[i].guess || c->mode == ECP_APART) continue;
            if (b[c->body_a].kind == ECP_DYNAMIC)
                most = ecp_i_max(most, c->p_n / b[c->body_a].mass);
            if (b[c->body_b].kind == ECP_DYNAMIC)
                most = ecp_i_max(most, c->p_n / b[c->body_b].mass);
        }
        press = most > 0 ? 32 * off / (w->last_h * most) : ECP_R(0);
        if (!ecp_i_still_step(a, w->last_h, press)) return;
        off = ecp_i_refresh_contacts(a);
    }
}

/* x^(1/k), within a few percent, by Newton, for x from 1e-3 to 1e3 */
static ecp_real ecp_i_near_root(ecp_real x, int k)
{
    ecp_real y = 1, power;
    int i, j;
    if (x > 1) y = 1 + (x - 1) / (ecp_real)k;
    for (i = 0; i < 60; i++) {
        ecp_real next;
        for (j = 1, power = 1; j < k; j++) power *= y;
        next = y + (x / power - y) / (ecp_real)k;
        if (ecp_i_abs(next - y) < ECP_R(1e-3) * y) return next;
        y = next;
    }
    return y;
}

/* the same for any x, one factor of 1000 at a time; for step sizes */
static ecp_real ecp_i_nth_root(ecp_real x, int k)
{
    ecp_real y;
    int down = 0;
    if (!(x > 0)) return 0;
    if (!ecp_i_finite(x)) return x;
    for (; x < ECP_R(1e-3); down++) x *= 1000;
    for (; x > ECP_R(1e3); down--) x /= 1000;
    y = ecp_i_near_root(x, k);
    for (; down > 0; down--) y /= ecp_i_near_root(ECP_R(1000.0), k);
    for (; down < 0; down++) y *= ecp_i_near_root(ECP_R(1000.0), k);
    return y;
}

typedef enum ecp_i_outcome {
    ECP_I_DONE,        /* smooth, within the tolerance */
    ECP_I_PASSED,      /* at first order, across a change */
    ECP_I_CHANGED,     /* a change lies in it */
    ECP_I_UNCONVERGED, /* too long for the tolerance */
    ECP_I_UNSOLVED     /* a base step failed */
} ecp_i_outcome;

/* ---- what a macro step would jump over: contacts that begin and end between the ends of its base steps, and
   those that base steps, which lag behind what the extrapolation makes of them, do not reach */

/* The way of a primitive's body in the macro step that leads from the saved state to the world's: the cubic through
   the poses at its ends, with its rates there (a whole macro step is the unit of time), of the centre of mass from x
   and of the turn from q in half tangents (ecp_i_changes). Where the macro step begins with an impact, the parabola
   with the last rate: the saved velocity is the one before. */
typedef struct ecp_i_way {
    const ecp_i_part *part;
    ecp_real x[3], q[4], change[6], first[6], last[6]; /* x from some origin */
} ecp_i_way;

static void ecp_i_way_of(const ecp_i_advance *a, int shape, const ecp_real origin[3],
                         ecp_i_way *way)
{
    const ecp_i_body *first = ecp_i_body_of(ecp_i_snapshot(a->saved), shape);
    const ecp_i_body *last = ecp_i_body_of(a->w, shape);
    const ecp_real *w = last->v + 3;
    ecp_real change[12], *g = change + 3, *rate = way->last;
    int k;
    way->part = ecp_i_parts(a->w) + shape;
    ecp_i_sub(first->x, origin, way->x);
    ecp_i_add(way->x, first->x_carry, way->x);
    ECPSIM_MEMCPY(way->q, first->q, sizeof way->q);
    ecp_i_changes(last, first, change);
    ECPSIM_MEMCPY(way->change, change, sizeof way->change);
    /* of half tangents g: g' = (w + w x g + (w . g) g) / 2 */
    ecp_i_cross(w, g, rate + 3);
    ecp_i_add(rate + 3, w, rate + 3);
    ecp_i_axpy(rate + 3, ecp_i_dot(w, g), g, rate + 3);
    ecp_i_scale(a->H / 2, rate + 3, rate + 3);
    ecp_i_scale(a->H, last->v, rate);
    ecp_i_scale(a->H, first->v, way->first);
    ecp_i_scale(a->H / 2, first->v + 3, way->first + 3);
    for (k = 0; a->impact && k < 6; k++) way->first[k] = 2 * change[k] - rate[k];
}

/* the pose at the part s of the macro step */
static void ecp_i_pose_on_way(const ecp_i_way *way, ecp_real s, ecp_i_posed *p)
{
    ecp_real by[6], turn[4], q[4], x[3];
    int k;
    for (k = 0; k < 6; k++) {
        by[k] = s * ((1 - s) * ((1 - s) * way->first[k] + s * (3 * way->change[k] - way->last[k])) +
                     s * s * way->change[k]);
    }
    ecp_i_add(way->x, by, x);
    turn[0] = 1;
    ecp_i_copy3(by + 3, turn + 1);
    ecp_quat_multiply(turn, way->q, q);
    ecp_i_quat_normalise(q);
    ecp_i_pose_part(way->part, q, x, p);
}

/* How far two primitives are apart there; less than 0 if they overlap by more than `slack`. n: the way out of A, as
   found where they were apart, or before that the way by which B comes. */
static ecp_real ecp_i_gap_on_way(const ecp_i_way *wa, const ecp_i_way *wb, ecp_real s,
                                 ecp_real slack, ecp_real n[3])
{
    ecp_real at_a[3], at_b[3], gap;
    ecp_i_posed A, B;
    ecp_i_pose_on_way(wa, s, &A);
    ecp_i_pose_on_way(wb, s, &B);
    if (!ECP_I_PAIRS || B.shape->kind == ECP_HALF_SPACE) {
        gap = ecp_i_plane_gap(&A, &B, 0, n, at_a);
        return gap < -slack ? gap : ecp_i_max(gap, 0);
    }
    gap = ecp_i_distance(&A, &B, at_a, at_b, n);
    if (gap > 0) return gap;
    ecp_i_axpy(B.x, slack, n, B.x);
    return ecp_i_distance(&A, &B, at_a, at_b, at_a) > 0 ? ECP_R(0) : -slack;
}

/* no rate on the way is larger: it is a mean of these three */
static ecp_real ecp_i_fastest_on_way(const ecp_real change[3], const ecp_real first[3],
                                     const ecp_real last[3])
{
    ecp_real middle[3];
    int k;
    for (k = 0; k < 3; k++) middle[k] = 3 * change[k] - first[k] - last[k];
    return ecp_i_max(ecp_i_norm(middle), ecp_i_max(ecp_i_norm(first), ecp_i_norm(last)));
}

/* how much nearer points of the two can come in the macro step, if they do so all the time */
static ecp_real ecp_i_nearing(const ecp_i_way *wa, const ecp_i_way *wb)
{
    ecp_real change[3], first[3], last[3], apart[3], speed, reach_a = ecp_i_part_reach(wa->part);
    ecp_real reach_b = ecp_i_part_reach(wb->part);
    ecp_i_sub(wa->change, wb->change, change);
    ecp_i_sub(wa->first, wb->first, first);
    ecp_i_sub(wa->last, wb->last, last);
    speed = ecp_i_fastest_on_way(change, first, last);
    if (wb->part->shape.kind == ECP_HALF_SPACE) {
        ecp_i_sub(wa->x, wb->x, apart);
        reach_b = ecp_i_norm(apart) + speed + reach_a;
    }
    return speed + 2 * reach_a * ecp_i_fastest_on_way(wa->change + 3, wa->first + 3, wa->last + 3) +
           2 * reach_b * ecp_i_fastest_on_way(wb->change + 3, wb->first + 3, wb->last + 3);
}

/* In what part of the macro step two that did not overlap do, by more than positions may be off; 2 if they do not.
   In strides that their gap takes at least. */
static ecp_real ecp_i_overlap_at(const ecp_i_advance *a, int shape_a, int shape_b)
{
    const ecp_world *first = ecp_i_snapshot(a->saved);
    const ecp_i_body *ba = ecp_i_body_of(first, shape_a), *bb = ecp_i_body_of(first, shape_b);
    ecp_real slack = 2 * a->o.tolerance * ecp_i_giving(ba, bb)->length, s = 0, nearing, n[3];
    ecp_i_way wa, wb;
    int apart = 0;
    ecp_i_way_of(a, shape_a, ba->x, &wa);
    ecp_i_way_of(a, shape_b, ba->x, &wb);
    nearing = ecp_i_nearing(&wa, &wb);
    if (wb.part->shape.kind != ECP_HALF_SPACE) {
        /* what ecp_i_distance tells from nothing, as the way of B need not be straight out of A */
        ecp_real radii = wa.part->shape.radius + wb.part->shape.radius;
        slack = ecp_i_max(slack, 8 * ecp_i_sqrt(ECP_I_EPSILON) * radii);
    }
    ecp_i_sub(wa.first, wb.first, n);
    ecp_i_normalise(n);
    for (;;) {
        ecp_real gap = ecp_i_gap_on_way(&wa, &wb, s, slack, n);
        if (apart && gap < 0) return s;
        if (gap >= 0) apart = 1;
        if (s >= 1 || gap >= nearing * (1 - s)) return 2;
        s = ecp_i_min(s + ecp_i_max(gap / nearing, ECP_R(1.0) / 256), 1);
    }
}

/* Does the macro step jump over a contact? Notes when. */
static int ecp_i_jumps(ecp_i_advance *a)
{
    ecp_real first = 2;
    int i, j;
    for (i = 0; i < a->w->shapes; i++) {
        for (j = 0; j < a->w->shapes; j++) {
            ecp_i_phase f;
            if (!ecp_i_can_touch(a->w, i, j)) continue;
            f.shape_a = i;
            f.shape_b = j;
            if (ecp_i_find_phase(a->now, a->now_count, &f)) continue;
            first = ecp_i_min(first, ecp_i_overlap_at(a, i, j));
        }
    }
    if (first > 1) return 0;
    a->nearest = ecp_i_min(a->nearest, first * a->H);
    a->changed = 1;
    return 1;
}

/* What the base steps of a column can not have seen of a load, in tolerances. They ask for it at their ends, so one
   that begins in the first of them acts from the beginning in all columns alike, and these agree. But as time goes by,
   at the state that was reached, loads at the beginning of the macro step and at the ends of base steps have to be
   those of a polynomial, which extrapolation takes them for: their difference of the order `column` is what the first
   is off by. It is summed where impulses are. */
static ecp_real ecp_i_unseen_load(ecp_i_advance *a, int column)
{
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    ecp_i_body *b = ecp_i_bodies(a->w);
    ecp_real h = a->H / (ecp_real)column, weight = 1, rounding = 4 * ECP_I_EPSILON, worst = 0;
    ecp_real shortest = ecp_i_shortest_length(a);
    int i, j, k;
    for (j = 0; j <= column; j++) {
        for (i = 0; i < a->w->bodies; i++) {
            if (before[i].kind == ECP_KINEMATIC) ecp_i_copy(6, before[i].v, b[i].v);
        }
        ecp_i_load_at(a, a->t + (ecp_real)j * h);
        for (i = 0; i < a->w->bodies; i++) {
            const ecp_real *sample = before[i].kind == ECP_KINEMATIC ? b[i].v : b[i].force;
            for (k = 0; k < 6; k++) {
                b[i].impulse[k] = (j > 0 ? b[i].impulse[k] : ECP_R(0)) + weight * sample[k];
            }
        }
        weight *= -(ecp_real)(column - j) / (ecp_real)(j + 1);
        rounding *= 2;
    }
    for (i = 0; i < a->w->bodies; i++) {
        const ecp_real *sample = before[i].kind == ECP_KINEMATIC ? b[i].v : b[i].force;
        ecp_real speed = ecp_i_max(ecp_i_speed_scale(a, before + i), ecp_i_speed_scale(a, b + i));
        ecp_real d[6];
        for (k = 0; k < 6; k++) {
            ecp_real off = b[i].impulse[k];
            d[k] = ecp_i_abs(off) > rounding * ecp_i_abs(sample[k]) ? h * off : ECP_R(0);
            b[i].impulse[k] = 0;
        }
        if (before[i].kind == ECP_KINEMATIC) {
            ecp_i_worst(&worst, ecp_i_norm(d) / shortest);
            ecp_i_worst(&worst, ecp_i_norm(d + 3));
        } else if (before[i].kind == ECP_DYNAMIC && speed > 0) {
            ecp_i_spin_change(b + i, d + 3);
            ecp_i_worst(&worst, ecp_i_norm(d) / (b[i].mass * speed));
            ecp_i_worst(&worst, ecp_i_norm(d + 3) * b[i].length / speed);
        }
    }
    return worst / a->o.tolerance;
}

/* One macro step of the length a->H, aimed at the order `aim`. *column: the last one; error[j]: the
   estimate of column j, from 2 on. The world holds the result if it is done or passed. */
static ecp_i_outcome ecp_i_macro(ecp_i_advance *a, int aim, int forced, int *column,
                                 ecp_real *error, ecp_status *status)
{
    int j, n = a->row, most = aim + 1 < a->o.order ? aim + 1 : a->o.order;
    ecp_real hidden, enough;
    a->changed = a->brief = a->impact = 0;
    a->nearest = a->H;
    for (j = 1; j <= most; j++) {
        *column = j;
        *status = ecp_i_macro_column(a, j);
        if (*status != ECP_OK) return ECP_I_UNSOLVED;
        if (j == 1) continue;
        /* phases that change in between: first order, and only if that hides nothing */
        if (j == 2 && !a->changed) ecp_i_check_beginning(a);
        hidden = ecp_i_hidden(a, a->rows + (j - 1) * n);
        if (a->changed || (a->brief && hidden > 1)) {
            if (!forced && hidden > 1) return ECP_I_CHANGED;
            error[j] = ecp_i_error(a, a->rows + (j - 1) * n, a->rows);
            return forced || error[j] <= 1 ? ECP_I_PASSED : ECP_I_CHANGED;
        }
        ecp_i_extrapolate(a, j);
        enough = j < aim ? ECP_R(1e-3) : ECP_R(1.0);
        error[j] = ecp_i_error(a, a->rows, a->rows + n);
        if (error[j] <= enough && a->o.load && !forced)
            ecp_i_worst(error + j, ecp_i_unseen_load(a, j));
        if (error[j] <= enough) {
            if (ecp_i_outlived(a) && hidden > 1 && !forced) {
                a->changed = 1;
                return ECP_I_CHANGED;
            }
            ecp_i_add_changes(a);
            return !forced && ecp_i_jumps(a) ? ECP_I_CHANGED : ECP_I_DONE;
        }
    }
    if (!forced) return ECP_I_UNCONVERGED;
    /* what is kept is the last column's, not what did not converge */
    error[most] = ecp_i_error(a, a->rows + (most - 1) * n, a->rows);
    return ECP_I_PASSED;
}

/* does nothing move any more? (no change by a macro step, no loads that could begin) */
static int ecp_i_at_rest(const ecp_i_advance *a)
{
    int i, n = 12 * a->w->bodies;
    if (a->o.load) return 0;
    for (i = 0; i < n; i++) {
        if (a->rows[i] != 0) return 0;
    }
    return 1;
}

/* The length and order of the next macro step: those of the least work in base steps per time. */
static ecp_real ecp_i_choose(const ecp_i_advance *a, int column, const ecp_real *error, int *aim)
{
    ecp_real best = 0, H = a->H, work = 0;
    int j;
    for (j = 2; j <= column; j++) {
        ecp_real most = a->o.load ? ECP_R(4.0) : ECP_R(8.0);
        ecp_real grow = error[j] > 0 ? ecp_i_nth_root(ECP_R(0.25) / error[j], j) : most, pace;
        grow = ECP_R(0.9) * ecp_i_min(grow, most);
        pace = a->H * grow / (ecp_real)(j * (j + 1) / 2);
        if (j == 2 || pace > best) {
            best = pace;
            *aim = j;
            H = a->H * grow;
            work = (ecp_real)(j * (j + 1) / 2);
        }
    }
    if (*aim == column && column < a->o.order && column > 1) {
        /* the last column was the best: one more is worth trying, at the same pace */
        *aim = column + 1;
        H *= (ecp_real)((column + 1) * (column + 2) / 2) / work;
    }
    return ecp_i_max(H, a->H * ECP_R(0.02));
}

ECP_DEF ecp_advance_options ecp_advance_options_default(void)
{
    ecp_advance_options o;
    ECPSIM_MEMSET(&o, 0, sizeof o);
    o.tolerance = sizeof(ecp_real) > 4 ? ECP_R(1e-6) : ECP_R(1e-3);
    return o;
}

/* impulses at once: they change velocities before anything else */
static void ecp_i_take_impulses(ecp_world *w)
{
    ecp_i_body *b = ecp_i_bodies(w);
    int i, k;
    for (i = 0; i < w->bodies; i++) {
        ecp_real dv[6];
        if (b[i].kind != ECP_DYNAMIC) continue;
        ecp_i_scale(1 / b[i].mass, b[i].impulse, dv);
        ecp_i_copy3(b[i].impulse + 3, dv + 3);
        ecp_i_spin_change(b + i, dv + 3);
        for (k = 0; k < 6; k++) {
            if (dv[k] != 0) ecp_i_add_carried(b[i].v + k, b[i].v_carry + k, dv[k]);
            b[i].impulse[k] = 0;
        }
    }
}

/* The largest speed of a body, in its lengths a second; of those that are driven, of their farthest points: what they
   come to may be at rest. */
static ecp_real ecp_i_fastest(const ecp_i_advance *a)
{
    ecp_real rate = 0, shortest = ecp_i_shortest_length(a);
    int i;
    for (i = 0; i < a->w->shapes; i++) {
        const ecp_i_part *part = ecp_i_parts(a->w) + i;
        const ecp_i_body *b;
        ecp_real reach = part->shape.kind == ECP_HALF_SPACE ? ECP_R(0) : ecp_i_part_reach(part);
        if (part->body == ECP_I_FREE) continue;
        b = ecp_i_body_of(a->w, i);
        if (b->kind != ECP_KINEMATIC) continue;
        rate = ecp_i_max(rate, (ecp_i_norm(b->v) + reach * ecp_i_norm(b->v + 3)) / shortest);
    }
    for (i = 0; i < a->w->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(a->w) + i;
        if (b->kind == ECP_DYNAMIC) rate = ecp_i_max(rate, ecp_i_speed_scale(a, b) / b->length);
    }
    return rate;
}

/* a first guess: what moves a body by a tenth of its length, or turns it by as much */
static ecp_real ecp_i_first_length(const ecp_i_advance *a)
{
    ecp_real rate = ecp_i_fastest(a);
    return rate > 0 ? ECP_R(0.1) / rate : ECP_R(1.0);
}

/* the longest macro step that turns no body by more than about one */
static ecp_real ecp_i_longest(const ecp_i_advance *a)
{
    ecp_real rate = 0;
    int i;
    for (i = 0; i < a->w->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(a->w) + i;
        if (ecp_i_moves(b)) rate = ecp_i_max(rate, ecp_i_norm(b->v + 3));
    }
    if (a->o.longest_step > 0) rate = ecp_i_max(rate, 1 / a->o.longest_step);
    return rate > 0 ? 1 / rate : ECP_I_NEVER;
}

/* the length below which nothing is told apart: what passes at the full speed is a quarter of the
   tolerance */
static ecp_real ecp_i_least(const ecp_i_advance *a)
{
    ecp_real rate = ecp_i_fastest(a);
    return rate > 0 ? ecp_i_max(a->o.tolerance / 4, 8 * ecp_i_sqrt(ECP_I_EPSILON)) / rate
                    : ECP_R(0);
}

/* How short macro steps may be: where events follow each other so densely that in a time in which a body
   moves by its length they take hundreds of base steps, the least length grows, and what happens within
   is passed at first order. Accumulations of impacts end in bounded work that way. Macro steps that are short because
   the tolerance or options.longest_step asks for it count for nothing. */
typedef struct ecp_i_patience {
    ecp_real since; /* where the present window begins */
    int solves;     /* base steps that events have taken in it */
} ecp_i_patience;

static ecp_real ecp_i_floor(const ecp_i_advance *a, ecp_i_patience *p)
{
    ecp_real least = ecp_i_least(a), scale = 10 * ecp_i_first_length(a);
    if (a->t - p->since > scale) {
        p->since = a->t;
        p->solves = 0;
    } else if (p->solves > 1500) {
        least = ecp_i_max(least, scale / 64);
    } else if (p->solves > 1000) {
        least = ecp_i_max(least, scale / 512);
    } else if (p->solves > 500) {
        least = ecp_i_max(least, scale / 4096);
    }
    /* where it is reached a macro step is forced, which one that is short on request is not to be */
    return a->o.longest_step > 0 ? ecp_i_min(least, a->o.longest_step / 4) : least;
}

/* The macro step as one step with all the fallbacks of ecp_step, or where even that fails a longer
   one: very short steps are not the easiest. */
static ecp_i_outcome ecp_i_plain_step(ecp_i_advance *a, ecp_real left, ecp_status *status)
{
    ecp_world *w = a->w;
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    int i, attempt;
    for (attempt = 0; attempt < 4; attempt++) {
        if (attempt > 0) a->H = attempt < 3 ? ecp_i_min(16 * a->H, left) : left;
        ECPSIM_MEMCPY(w, a->saved, w->state_bytes);
        ecp_i_load_at(a, a->t + a->H);
        ecp_i_rates(a, 0, -1 / a->H);
        w->advancing = 0;
        ecp_i_clear_report(&a->r->step);
        if (ecp_i_may(&a->step, ECP_FALLBACK_SUBSTEPS))
            *status = ecp_i_step_by_parts(w, a->H, &a->step, a->bytes, 0, &a->r->step);
        else
            *status = ecp_i_step_once(w, a->H, &a->step, a->bytes, NULL, &a->r->step);
        w->advancing = 1;
        a->r->solves += a->r->step.substeps;
        a->r->step.status = *status;
        if (*status != ECP_NOT_SOLVED || a->H >= left) break;
    }
    if (*status != ECP_OK) return ECP_I_UNSOLVED;
    ecp_i_clear_failure(&a->r->step);
    ecp_i_rates(a, 1, 1 / a->H);
    for (i = 0; i < w->bodies; i++) {
        if (ecp_i_moves(before + i)) {
            ecp_i_changes(ecp_i_bodies(w) + i, before + i, a->rows + 12 * i);
        }
    }
    return ECP_I_PASSED;
}

/* notes what an accepted macro step did, for those that follow */
static void ecp_i_note_macro(ecp_i_advance *a, int passed)
{
    int i, k;
    ecp_real *forces = a->rows + 12 * a->w->bodies;
    ecp_i_phase *list = a->here;
    ECPSIM_MEMCPY(a->rate, a->rate_now, (size_t)(6 * a->w->bodies) * sizeof(ecp_real));
    i = ecp_i_phases(a, a->here);
    if (passed) ecp_i_forces(a->w, a->w->last_h, forces);
    for (k = 0; k < i; k++) {
        const ecp_i_phase *before = ecp_i_find_phase(a->last, a->last_count, list + k);
        int m, known = !passed && before && before->mode == list[k].mode &&
                       ecp_i_same_faces(before, list + k);
        ecp_i_margins(a, list + k, forces + ECP_I_FORCES * k, list[k].margin);
        for (m = 0; m < 3; m++) {
            list[k].rate[m] = known ? (list[k].margin[m] - before->margin[m]) / a->H : ECP_R(0);
        }
    }
    a->here = a->last;
    a->last = list;
    a->last_count = i;
    a->r->macro_steps++;
    if (a->r->macro_steps == 1 || a->H < a->r->shortest) a->r->shortest = a->H;
}

/* What the state that is saved says about the phase ahead: 1 if it can begin. */
static int ecp_i_arrived(ecp_i_advance *a)
{
    int fits = ecp_i_phase_fits(a, &a->ahead);
    if (a->ahead.mode == ECP_STICK && fits) {
        const ecp_i_phase *before = ecp_i_find_phase(a->last, a->last_count, &a->ahead);
        if (before && before->mode == ECP_SLIP) fits = ecp_i_stick_fits(a, &a->ahead);
    }
    return fits;
}

/* the lowest order that should do for a macro step of the length H, after one of the length `before` */
static int ecp_i_enough(ecp_real before, int aim, int column, const ecp_real *error, ecp_real H)
{
    int j, k;
    if (column < 2) return 3;
    for (j = 2; j < aim && j <= column; j++) {
        ecp_real e = error[j];
        for (k = 0; k < j; k++) e *= H / before;
        if (e < ECP_R(0.1)) return j;
    }
    return aim;
}

/* The saved state goes on as it did last, for a time that is too short for a step: what is neglected is
   of the third order in it, and of the second in velocities. */
static void ecp_i_drift(ecp_i_advance *a, ecp_real time)
{
    ecp_world *w = a->w;
    ecp_i_body *b = ecp_i_bodies(w);
    ecp_real dv[6], mean[6];
    int i, k;
    ECPSIM_MEMCPY(w, a->saved, w->state_bytes);
    for (i = 0; i < w->bodies; i++) {
        if (!ecp_i_moves(b + i)) continue;
        for (k = 0; k < 6; k++) {
            dv[k] = b[i].kind == ECP_DYNAMIC ? time * a->rate[6 * i + k] : ECP_R(0);
            mean[k] = b[i].v[k] + dv[k] / 2;
        }
        for (k = 0; k < 3; k++) ecp_i_add_carried(b[i].x + k, b[i].x_carry + k, time * mean[k]);
        ecp_i_turn_for(b + i, mean + 3, time);
        for (k = 0; k < 6; k++) ecp_i_add_carried(b[i].v + k, b[i].v_carry + k, dv[k]);
    }
    ECPSIM_MEMCPY(a->saved, w, w->state_bytes);
    a->t += time;
}

/* After a macro step with a change in it, until that is passed: where the next one should end, of the time that is
   left. The time until the phase ahead, or until a margin is gone; H if neither is near. Returns 0 where the state
   allows the phase ahead at once, if need be after a time that is too short for a macro step. */
static ecp_real ecp_i_hunt(ecp_i_advance *a, ecp_real H, ecp_real least, ecp_real left)
{
    ecp_real to = H, rate = ecp_i_fastest(a);
    /* Macro steps that short would be all rounding. What it neglects in velocities, half the square of this in their
       scale, is an eighth of the tolerance, unless loads have a will of their own. */
    a->drift = least;
    if (rate > 0 && !a->o.load)
        a->drift = ecp_i_max(least, ecp_i_sqrt(a->o.tolerance) / (2 * rate));
    a->nearest = ECP_I_NEVER;
    if (a->looking && ecp_i_arrived(a)) return 0;
    if (a->looking && a->nearest < left && a->nearest < (a->exact ? a->drift : least)) {
        ecp_i_drift(a, a->nearest);
        return 0;
    }
    to = ecp_i_min(to, a->nearest);
    to = ecp_i_min(to, ecp_i_margin_time(a));
    return to < least ? H : to;
}

/* what follows an accepted macro step; `error` in tolerances */
static void ecp_i_accept(ecp_i_advance *a, int passed, int order, ecp_real error, ecp_real duration)
{
    int rest = !passed && ecp_i_at_rest(a);
    ecp_i_worst(&a->r->error, error);
    a->r->first_order += passed;
    a->r->forced += passed && error > 1;
    a->r->events += passed || a->impact || a->brief;
    if (!passed && order > a->r->highest_order) a->r->highest_order = order;
    ecp_i_note_macro(a, passed);
    if (!rest) ecp_i_project_velocities(a);
    ecp_i_project(a);
    a->t = a->H < duration - a->t && !rest ? a->t + a->H : duration;
    a->r->reached = a->t;
}

/* ---- an impact alone */

/* The time until the first of the patches meets that close and are within the tolerance of it, or so
   near that no macro step is as short; less than 0 if there is none, or if there are others than on
   half-spaces. Of the state that is saved, and the phases of the first column. */
static ecp_real ecp_i_meeting(const ecp_i_advance *a)
{
    const ecp_world *w = ecp_i_snapshot(a->saved);
    ecp_real first = -1;
    int i;
    for (i = 0; i < a->now_count; i++) {
        const ecp_i_phase *f = a->now + i;
        const ecp_i_body *b =
            ecp_i_giving(ecp_i_body_of(w, f->shape_a), ecp_i_body_of(w, f->shape_b));
        ecp_real n[3], at[3], v[3], gap, speed, time;
        if (ecp_i_parts(w)[f->shape_b].shape.kind != ECP_HALF_SPACE) return -1;
        gap = ecp_i_gap_at_first(w, f, n, at, v);
        speed = ecp_i_dot(n, v);
        if (!(speed > 4 * a->o.tolerance * ecp_i_speed_scale(a, b))) continue;
        time = ecp_i_max(gap, 0) / speed;
        if (gap > a->o.tolerance * b->length && time > ecp_i_least(a)) continue;
        if (first < 0 || time < first) first = time;
    }
    return first;
}

/* The velocities that an impact leaves at the pose of the saved state: those of one base step,
   extrapolated to none of its length. Returns 1 if the world has them, within the tolerance. */
static int ecp_i_velocities_after(ecp_i_advance *a, ecp_real h)
{
    ecp_world *w = a->w;
    const ecp_i_body *before = ecp_i_bodies(ecp_i_snapshot(a->saved));
    ecp_real last = 0;
    int i, j, k;
    a->now_count = 0;
    for (j = 1; j <= a->o.order; j++) {
        ecp_real *row = a->rows + (j - 1) * a->row, shorter = h / (ecp_real)j, error;
        ECPSIM_MEMCPY(w, a->saved, w->state_bytes);
        ecp_i_load_at(a, a->t + shorter);
        ecp_i_clear_report(&a->r->step);
        a->r->solves++;
        a->r->step.status = ecp_i_step_once(w, shorter, &a->step, a->bytes, NULL, &a->r->step);
        if (a->r->step.status != ECP_OK) return 0;
        for (i = 0; i < w->bodies; i++, row += 12) {
            if (!ecp_i_moves(before + i)) continue;
            ecp_i_changes(ecp_i_bodies(w) + i, before + i, row);
            for (k = 0; k < 6; k++) row[k] = 0;
        }
        if (j == 1) continue;
        ecp_i_extrapolate(a, j);
        error = ecp_i_error(a, a->rows, a->rows + a->row);
        if (error <= ECP_R(0.1)) {
            ecp_i_add_changes(a);
            return 1;
        }
        if (j > 2 && !(error < ECP_R(0.5) * last)) return 0;
        last = error;
    }
    return 0;
}

/* Where a macro step that begins with an impact cannot have the same phases throughout, as patches do
   not carry in the impact as they do after it (a table that falls back on all its legs): the
   impact alone, in no time. What follows begins as a call does. Returns 1 if that is done; else the
   state saved may be that in which they meet. left: the time until the end, before which they must. */
static int ecp_i_impact_alone(ecp_i_advance *a, ecp_real left)
{
    ecp_real time = ecp_i_meeting(a), h = ecp_i_first_length(a);
    int attempt;
    if (!(time >= 0 && time < left)) return 0;
    ECPSIM_MEMCPY(a->w, a->saved, a->w->state_bytes);
    ecp_i_drift(a, time);
    for (attempt = 0; attempt < 3; attempt++, h /= 8) {
        if (!ecp_i_velocities_after(a, h)) continue;
        a->r->events++;
        a->last_count = 0;
        ecp_i_project_velocities(a);
        ecp_i_project(a);
        return 1;
    }
    ECPSIM_MEMCPY(a->w, a->saved, a->w->state_bytes);
    return 0;
}

/* Saves the state in which a macro step begins, and notes what accelerates bodies there: without gravity, what loads
   do to one that hardly moves is the only scale of its velocities. Turns count by their lengths. */
static void ecp_i_save(ecp_i_advance *a)
{
    ecp_i_body *b = ecp_i_bodies(a->w);
    int i;
    ECPSIM_MEMCPY(a->saved, a->w, a->w->state_bytes);
    ecp_i_load_at(a, a->t);
    a->push = ecp_i_norm(a->w->desc.gravity);
    for (i = 0; i < a->w->bodies; i++) {
        if (b[i].kind != ECP_DYNAMIC) continue;
        ecp_i_spin_change(b + i, b[i].force + 3);
        ecp_i_raise(&a->push, ecp_i_norm(b[i].force) / b[i].mass);
        ecp_i_raise(&a->push, ecp_i_norm(b[i].force + 3) * b[i].length);
    }
    ECPSIM_MEMCPY(a->w, a->saved, a->w->state_bytes);
}

/* macro steps of one length and order, whatever the error */
static ecp_status ecp_i_advance_paced(ecp_i_advance *a, ecp_real duration)
{
    ecp_status status = ECP_OK;
    while (a->t < duration) {
        ecp_real left = duration - a->t, error = 0;
        int j, n = a->row;
        /* (no sliver at the end) */
        a->H = a->o.macro_step < left * ECP_R(0.9999) ? a->o.macro_step : left;
        if (a->o.max_solves > 0 && a->r->solves >= a->o.max_solves) return ECP_NOT_SOLVED;
        ecp_i_save(a);
        a->changed = a->brief = a->impact = 0;
        a->nearest = a->H;
        for (j = 1; j <= a->o.order && status == ECP_OK; j++) {
            status = ecp_i_macro_column(a, j);
            if (status != ECP_OK || j == 1) continue;
            error = ecp_i_error(a, a->rows + (j - 1) * n, a->rows);
            if (a->changed) continue;
            ecp_i_extrapolate(a, j);
            error = ecp_i_error(a, a->rows, a->rows + n);
        }
        if (status == ECP_NOT_SOLVED) {
            /* shorter ones, at first order */
            if (ecp_i_plain_step(a, a->H, &status) == ECP_I_PASSED) {
                a->changed = 1;
                error = ecp_i_max(error, 2);
            }
        }
        if (status != ECP_OK) return status;
        if (!a->changed) ecp_i_add_changes(a);
        ecp_i_accept(a, a->changed, a->o.order, error, duration);
    }
    return ECP_OK;
}

/* after so many macro steps in vain an impact alone is tried */
#define ECP_I_IN_VAIN 6

/* How long the next macro step is to be, and of which order; the errors and the length of the last good one */
typedef struct ecp_i_pace {
    ecp_real H, smooth; /* smooth: the length before an event was looked for */
    ecp_real error[ECP_I_MAX_ORDER + 1], good[ECP_I_MAX_ORDER + 1], good_H;
    int aim, column, good_column;
    int hunting;      /* for so many macro steps an event is looked for */
    int rejected;     /* was the last one? */
    int in_vain;      /* so many in a row whose phases changed */
    int impact_tried; /* an impact alone, since a macro step was accepted: it takes no time */
} ecp_i_pace;

/* as a call begins, and after an impact alone */
static void ecp_i_pace_begin(const ecp_i_advance *a, ecp_i_pace *p)
{
    p->H = ecp_i_first_length(a);
    p->aim = 3;
    p->hunting = p->rejected = p->in_vain = 0;
}

/* the order that lets the error of the last good one be reached with this length */
static void ecp_i_pace_aim(const ecp_i_advance *a, ecp_i_pace *p)
{
    p->aim = ecp_i_enough(p->good_H, a->o.order, p->good_column, p->good, p->H);
}

/* the length of the macro step that is tried, a->H; drifts on where nothing happens until an event */
static void ecp_i_pace_choose(ecp_i_advance *a, ecp_i_pace *p, ecp_real least, ecp_real duration)
{
    ecp_real left = duration - a->t;
    if (p->hunting > 0 && !p->rejected) {
        ecp_real to = ecp_i_hunt(a, p->H, least, left);
        if (!(to > 0)) {
            a->looking = p->hunting = 0;
            p->H = ecp_i_max(p->H, p->smooth / 4);
            p->aim = 4;
        } else if (to < p->H) {
            p->H = to;
            ecp_i_pace_aim(a, p);
        }
        left = duration - a->t;
    }
    p->H = ecp_i_max(ecp_i_min(p->H, ecp_i_longest(a)), least);
    a->H = p->H < left ? p->H : left;
    if (a->H < left && a->H > left * ECP_R(0.8)) a->H = left / 2;
}

/* after a macro step that was done, or passed an event at first order */
static void ecp_i_pace_accepted(ecp_i_advance *a, ecp_i_pace *p, int passed)
{
    if (passed || a->impact || a->brief) a->looking = p->hunting = 0;
    if (passed) {
        p->H = 2 * a->H;
        p->aim = 2;
        return;
    }
    ECPSIM_MEMCPY(p->good, p->error, sizeof p->good);
    p->good_column = p->column;
    p->good_H = a->H;
    p->H = ecp_i_choose(a, p->column, p->error, &p->aim);
    if (!(p->hunting > 0)) {
        a->looking = 0;
        p->smooth = p->H;
        return;
    }
    /* no longer than the last one was, for some time */
    p->hunting--;
    if (p->H > a->H) {
        p->H = a->H;
        ecp_i_pace_aim(a, p);
    }
}

/* after one that was not */
static void ecp_i_pace_rejected(ecp_i_advance *a, ecp_i_pace *p, ecp_i_outcome outcome,
                                ecp_real least)
{
    p->in_vain += outcome == ECP_I_CHANGED;
    if (outcome == ECP_I_UNSOLVED) {
        p->H = a->H / 4;
    } else if (outcome == ECP_I_UNCONVERGED) {
        p->H = ecp_i_min(ecp_i_choose(a, p->column, p->error, &p->aim), a->H / 2);
    } else if (a->brief && !a->changed) {
        /* it is at the beginning: short enough to hide nothing, as far as first order can tell */
        ecp_real hides = ecp_i_hidden(a, a->rows);
        p->H = a->H * (hides > 4 ? ECP_R(0.9) / ecp_i_sqrt(hides) : ECP_R(0.5));
        p->hunting = 12;
        p->aim = 2;
    } else {
        p->hunting = 12;
        p->H = ecp_i_min(a->nearest, ecp_i_margin_time(a));
        if (!(p->H < ECP_R(0.95) * a->H) || p->H < least) p->H = a->H / 2;
        ecp_i_pace_aim(a, p);
    }
}

/* the phases may be those of an impact alone: tried once, at the latest before a macro step is forced */
static int ecp_i_pace_tries_impact(ecp_i_advance *a, ecp_i_pace *p, int forced, ecp_real left)
{
    if (p->impact_tried || p->in_vain < (forced ? 1 : ECP_I_IN_VAIN)) return 0;
    p->impact_tried = 1;
    return ecp_i_impact_alone(a, left);
}

static ecp_status ecp_i_advance_to(ecp_i_advance *a, ecp_real duration)
{
    ecp_i_pace p;
    ecp_i_patience patience = {0, 0};
    ecp_status status = ECP_OK;
    ECPSIM_MEMSET(&p, 0, sizeof p);
    ecp_i_save(a);
    ecp_i_pace_begin(a, &p);
    p.smooth = p.H;
    for (; a->t < duration; ecp_i_save(a)) {
        ecp_i_outcome outcome;
        /* (and no shorter than what is a step in time at all, so far) */
        ecp_real now = ecp_i_max(a->t, ecp_i_min(ecp_i_first_length(a), duration));
        ecp_real least = ecp_i_max(ecp_i_floor(a, &patience), ECP_I_EPSILON * now);
        int forced, solves = a->r->solves;
        if (a->o.max_solves > 0 && solves >= a->o.max_solves) return ECP_NOT_SOLVED;
        ecp_i_pace_choose(a, &p, least, duration);
        forced = a->H <= least;
        if (ecp_i_pace_tries_impact(a, &p, forced, duration - a->t)) {
            a->looking = 0;
            ecp_i_pace_begin(a, &p);
            continue;
        }
        outcome = ecp_i_macro(a, p.aim < a->o.order ? p.aim : a->o.order, forced, &p.column,
                              p.error, &status);
        if (outcome == ECP_I_UNSOLVED && forced && status == ECP_NOT_SOLVED) {
            ecp_real left = duration - a->t;
            if (a->o.longest_step > 0) left = ecp_i_min(left, a->o.longest_step);
            outcome = ecp_i_plain_step(a, left, &status);
            p.column = 1;
            p.error[1] = 2;
        }
        p.rejected = outcome != ECP_I_DONE && outcome != ECP_I_PASSED;
        if (outcome != ECP_I_DONE || p.hunting > 0) patience.solves += a->r->solves - solves;
        if (!p.rejected) {
            p.in_vain = p.impact_tried = 0;
            ecp_i_accept(a, outcome == ECP_I_PASSED, p.column, p.error[p.column], duration);
            ecp_i_pace_accepted(a, &p, outcome == ECP_I_PASSED);
            continue;
        }
        a->r->rejected++;
        ECPSIM_MEMCPY(a->w, a->saved, a->w->state_bytes);
        /* the longer a base step, the more patches it may reach */
        if (outcome == ECP_I_UNSOLVED &&
            ((status != ECP_NOT_SOLVED && status != ECP_CAPACITY) || forced))
            return status;
        ecp_i_pace_rejected(a, &p, outcome, least);
    }
    return ECP_OK;
}

static ecp_status ecp_i_check_advance(const ecp_world *w, ecp_real duration,
                                      const ecp_advance_options *o, const ecp_options *step)
{
    ecp_status status = ecp_i_check_options(step);
    int i;
    if (status != ECP_OK) return status;
    if (w->advancing) return ECP_BAD_OPTION; /* within its own callback */
    if (w->desc.advance_order == 0) return ECP_CAPACITY;
    if (!ecp_i_finite(duration) || !ecp_i_finite(o->tolerance) || !ecp_i_finite(o->macro_step) ||
        !ecp_i_finite(o->time) || !ecp_i_finite(o->longest_step)) {
        return ECP_NOT_FINITE;
    }
    if (!(duration >= 0)) return ECP_BAD_STEP;
    if (o->order == 1 || o->order < 0 || o->max_solves < 0 || !(o->macro_step >= 0) ||
        !(o->longest_step >= 0)) {
        return ECP_BAD_OPTION;
    }
    if (o->order > w->desc.advance_order) return ECP_CAPACITY;
    if (!(o->tolerance > 0)) return ECP_BAD_OPTION;
    if (o->longest_step > 0 && !(o->longest_step > ECP_I_EPSILON * duration)) return ECP_BAD_STEP;
    if (o->macro_step > 0) return o->macro_step > ECP_I_EPSILON * duration ? ECP_OK : ECP_BAD_STEP;
    /* rounding: of the base steps' equations, and of gaps as differences of positions */
    if (o->tolerance < 16 * step->tolerance) return ECP_TOLERANCE;
    for (i = 0; i < w->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(w) + i;
        if (b->kind != ECP_DYNAMIC) continue;
        if (o->tolerance < 64 * ECP_I_EPSILON * (1 + ecp_i_norm(b->x) / b->length)) {
            return ECP_TOLERANCE;
        }
    }
    return ECP_OK;
}

ECP_DEF ecp_status ecp_advance(ecp_world *world, ecp_real duration,
                               const ecp_advance_options *options, ecp_advance_report *report)
{
    ecp_i_advance a;
    ecp_i_arena arena;
    ecp_advance_report r;
    int i;
    ECPSIM_MEMSET(&a, 0, sizeof a);
    ECPSIM_MEMSET(&r, 0, sizeof r);
    ecp_i_clear_report(&r.step);
    a.w = world;
    a.r = &r;
    a.o = options ? *options : ecp_advance_options_default();
    a.step = a.o.step ? *a.o.step : ecp_options_default();
    r.status = world ? ecp_i_check_advance(world, duration, &a.o, &a.step) : ECP_BAD_POINTER;
    if (report) *report = r;
    if (r.status != ECP_OK) return r.status;
    if (a.o.order == 0) a.o.order = world->desc.advance_order;
    /* its memory is the end of the block */
    a.bytes = ecp_i_bytes(ecp_i_advance_bytes(world), 1);
    arena = ecp_i_arena_over((unsigned char *)world + world->bytes - a.bytes, a.bytes);
    ecp_i_carve_advance(&arena, world, &a);
    ECPSIM_ASSERT(!arena.overflow);
    ECPSIM_MEMCPY(a.first, world, world->state_bytes);
    /* base steps know no sleep, and after them nobody sleeps */
    ECPSIM_MEMSET(&world->asked, 0, sizeof world->asked);
    for (i = 0; i < world->bodies; i++) ecp_i_bodies(world)[i].asleep = 0;
    ecp_i_take_impulses(world);
    world->advancing = 1;
    /* overlaps first, and at rest: depth / h has no limit where h has none */
    if (duration > 0 && ecp_i_overlaps(world)) ecp_i_still_step(&a, duration, 0);
    r.status =
        a.o.macro_step > 0 ? ecp_i_advance_paced(&a, duration) : ecp_i_advance_to(&a, duration);
    world->advancing = 0;
    /* near overflow: an error that no one knows, or a state that is no number */
    if (r.status == ECP_OK && r.error != r.error) r.status = ECP_NOT_FINITE;
    for (i = 0; r.status == ECP_OK && i < world->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(world) + i;
        if (!ecp_i_all_finite(3, b->x) || !ecp_i_all_finite(4, b->q) || !ecp_i_all_finite(6, b->v))
            r.status = ECP_NOT_FINITE;
    }
    if (r.status != ECP_OK) ECPSIM_MEMCPY(world, a.first, world->state_bytes);
    for (i = 0; r.status == ECP_OK && i < world->bodies; i++) {
        ecp_i_body *b = ecp_i_bodies(world) + i;
        ECPSIM_MEMSET(b->force, 0, sizeof b->force);
    }
    /* work memory is zero outside a call */
    ECPSIM_MEMSET(a.first, 0, a.bytes);
    if (report) *report = r;
    return r.status;
}

/* >>dump ==================================================================================
   A step as C source. The tables have the fields of the structs in their order: the compiler warns
   where one is missing, and tests/dump.c compares the bits. */

typedef struct ecp_i_text {
    void (*write)(void *user, const char *text);
    void *user;
} ecp_i_text;

static void ecp_i_put(const ecp_i_text *t, const char *text) { t->write(t->user, text); }

static void ecp_i_put_digits(const ecp_i_text *t, uint32_t value, uint32_t base)
{
    char text[11];
    int at = 10;
    text[at] = 0;
    do {
        text[--at] = "0123456789abcdef"[value % base];
        value /= base;
    } while (value > 0);
    ecp_i_put(t, text + at);
}

/* hexadecimal, with all eight digits of the lower half: a constant has the first type that holds it */
static void ecp_i_put_size(const ecp_i_text *t, size_t value)
{
    uint32_t low = (uint32_t)(value & 0xffffffffu);
    int k;
    ecp_i_put(t, "0x");
    ecp_i_put_digits(t, (uint32_t)((value >> 16) >> 16), 16);
    for (k = 28; k > 0 && low >> k == 0; k -= 4) ecp_i_put(t, "0");
    ecp_i_put_digits(t, low, 16);
}

static void ecp_i_put_int(const ecp_i_text *t, const char *before, int value, const char *after)
{
    uint32_t size = (uint32_t)value;
    ecp_i_put(t, before);
    if (value < 0) {
        ecp_i_put(t, "-");
        size = 0 - size;
    }
    ecp_i_put_digits(t, size, 10);
    ecp_i_put(t, after);
}

/* digits that bring every real back */
#ifdef ECPSIM_FLOAT
#define ECP_I_DIGITS 9
#else
#define ECP_I_DIGITS 17
#endif

/* An integer in words of eight decimal digits, the lowest first. The longest, 2^53 5^1074 for the
   smallest numbers that there are, has 767 digits. */
typedef struct ecp_i_integer {
    uint32_t word[100];
    int words;
} ecp_i_integer;

/* n = factor n + add, for a small factor */
static void ecp_i_integer_times(ecp_i_integer *n, uint32_t factor, uint32_t add)
{
    int i;
    for (i = 0; i < n->words; i++) {
        add += factor * n->word[i];
        n->word[i] = add % 100000000u;
        add /= 100000000u;
    }
    if (add > 0) n->word[n->words++] = add;
}

/* a finite x > 0 as n / 10^places, exactly: the bits of x one after the other, and 1 / 2 = 5 / 10 */
static void ecp_i_expand(ecp_real x, ecp_i_integer *n, int *places)
{
    int power = 1;
    n->words = 0;
    *places = 0;
    for (; x >= 2; power++) x /= 2;
    for (; x < 1; power--) x *= 2;
    for (; x > 0; power--) {
        int bit = x >= 1;
        ecp_i_integer_times(n, 2, bit ? 1u : 0u);
        x = 2 * (bit ? x - 1 : x);
    }
    for (; power > 0; power--) ecp_i_integer_times(n, 2, 0);
    for (; power < 0; power++, ++*places) ecp_i_integer_times(n, 5, 0);
}

/* The digits d1 d2 .. of x = 0.d1 d2 .. 10^point, as characters, rounded to ECP_I_DIGITS, without
   zeros at the end. Returns how many they are. */
static int ecp_i_decimal(ecp_real x, char digits[ECP_I_DIGITS], int *point)
{
    ecp_i_integer n;
    int i, k, count = 0, places, up = 0;
    ecp_i_expand(x, &n, &places);
    for (i = 8 * n.words - 1; i >= 0; i--) {
        uint32_t digit = n.word[i / 8];
        for (k = 0; k < i % 8; k++) digit /= 10;
        digit %= 10;
        if (count == 0 && digit == 0) continue;
        if (count < ECP_I_DIGITS) digits[count] = (char)('0' + (int)digit);
        if (count++ == ECP_I_DIGITS) up = digit >= 5;
    }
    *point = count - places;
    if (count > ECP_I_DIGITS) count = ECP_I_DIGITS;
    /* rounded up, nines are zeros and carry */
    while (count > 0 && digits[count - 1] == (up ? '9' : '0')) count--;
    if (up && count > 0) digits[count - 1]++;
    if (count == 0) {
        digits[count++] = '1';
        ++*point;
    }
    return count;
}

static void ecp_i_put_real(const ecp_i_text *t, ecp_real x)
{
    unsigned char bytes[sizeof x];
    char digits[ECP_I_DIGITS], text[ECP_I_DIGITS + 8];
    int count, point, fixed, i, at = 0, negative = x < 0;
    unsigned k;
    ECPSIM_MEMCPY(bytes, &x, sizeof x);
    for (k = 0; k < sizeof x; k++) negative |= x == 0 && bytes[k] != 0;
    if (negative) ecp_i_put(t, "-");
    if (negative) x = -x;
    if (!ecp_i_finite(x)) {
        ecp_i_put(t, x > 0 ? "INFINITY" : "NAN");
        return;
    }
    if (x < 1000000 && x == (ecp_real)(int)x) {
        ecp_i_put_int(t, "", (int)x, negative && !(x > 0) ? ".0" : "");
        return;
    }
    count = ecp_i_decimal(x, digits, &point);
    fixed = point > -4 && point < count;
    for (i = fixed && point < 1 ? point - 1 : 0; i < count; i++) {
        text[at++] = i < 0 ? '0' : digits[i];
        if (i + 1 == (fixed ? point : 1) && i + 1 < count) text[at++] = '.';
    }
    text[at] = 0;
    ecp_i_put(t, text);
    if (!fixed) ecp_i_put_int(t, "e", point - 1, "");
    if (sizeof x == sizeof(float)) ecp_i_put(t, "f");
}

/* fields of a table, with their name: a number; and a list, `row` numbers on a line */
static void ecp_i_put_field(const ecp_i_text *t, const char *name, ecp_real x)
{
    ecp_i_put(t, "         ");
    ecp_i_put_real(t, x);
    ecp_i_put(t, ", /* ");
    ecp_i_put(t, name);
    ecp_i_put(t, " */\n");
}

static void ecp_i_put_list(const ecp_i_text *t, const char *name, const ecp_real *x, int n, int row)
{
    int i;
    ecp_i_put(t, "         {");
    for (i = 0; i < n; i++) {
        if (i > 0) ecp_i_put(t, i % row ? ", " : ",\n          ");
        ecp_i_put_real(t, x[i]);
    }
    ecp_i_put(t, "}, /* ");
    ecp_i_put(t, name);
    ecp_i_put(t, " */\n");
}

static void ecp_i_put_bodies(const ecp_i_text *t, const ecp_world *w)
{
    static const char *const kinds[4] = {"ECP_I_FREE", "ECP_STATIC", "ECP_KINEMATIC",
                                         "ECP_DYNAMIC"};
    int i;
    if (w->bodies == 0) return;
    ecp_i_put_int(t, "    static const ecp_i_body bodies[", w->bodies, "] = {\n");
    for (i = 0; i < w->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(w) + i;
        ecp_i_put_int(t, "        {/* body ", i, " */\n");
        ecp_i_put_field(t, "mass", b->mass);
        ecp_i_put_field(t, "length", b->length);
        ecp_i_put_list(t, "inertia", b->inertia, 9, 3);
        ecp_i_put_list(t, "x", b->x, 3, 3);
        ecp_i_put_list(t, "q", b->q, 4, 4);
        ecp_i_put_list(t, "v", b->v, 6, 3);
        ecp_i_put_list(t, "x_carry", b->x_carry, 3, 3);
        ecp_i_put_list(t, "v_carry", b->v_carry, 6, 3);
        ecp_i_put_list(t, "q_carry", b->q_carry, 4, 4);
        ecp_i_put_list(t, "force", b->force, 6, 3);
        ecp_i_put_list(t, "impulse", b->impulse, 6, 3);
        ecp_i_put(t, "         ");
        ecp_i_put(t, kinds[b->kind - ECP_I_FREE]);
        ecp_i_put_int(t, ", ", b->asleep, "}, /* kind, asleep */\n");
    }
    ecp_i_put(t, "    };\n");
}

/* the planes and vertices of a polytope, rows of `row` numbers */
static void ecp_i_put_array(const ecp_i_text *t, const char *name, int shape, const ecp_real *x,
                            int rows, int row)
{
    ecp_i_put(t, "    static const ecp_real ");
    ecp_i_put_int(t, name, shape, "");
    ecp_i_put_int(t, "[", rows * row, "] = {\n");
    while (rows-- > 0) {
        int k;
        ecp_i_put(t, "        ");
        for (k = 0; k < row; k++) {
            ecp_i_put_real(t, *x++);
            ecp_i_put(t, k + 1 < row ? ", " : ",\n");
        }
    }
    ecp_i_put(t, "    };\n");
}

static void ecp_i_put_shape(const ecp_i_text *t, int i, const ecp_shape *s)
{
    static const char *const kinds[9] = {"&ecp_i_half_space_class, ECP_HALF_SPACE",
                                         "&ecp_i_sphere_class, ECP_SPHERE",
                                         "&ecp_i_ellipsoid_class, ECP_ELLIPSOID",
                                         "&ecp_i_capsule_class, ECP_CAPSULE",
                                         "&ecp_i_cylinder_class, ECP_CYLINDER",
                                         "&ecp_i_frustum_class, ECP_FRUSTUM",
                                         "&ecp_i_box_class, ECP_BOX",
                                         "&ecp_i_polytope_class, ECP_POLYTOPE",
                                         "NULL /* the class is missing */, ECP_CONVEX"};
    ecp_i_put(t, "         {");
    ecp_i_put(t, s->cls ? kinds[s->kind] : "NULL, ECP_HALF_SPACE");
    ecp_i_put_int(t, ", ", s->inequalities, ", ");
    ecp_i_put_int(t, "", s->vertex_count, ",\n");
    ecp_i_put_list(t, "size", s->size, 4, 4);
    ecp_i_put_list(t, "centre", s->centre, 3, 3);
    ecp_i_put_field(t, "radius", s->radius);
    if (s->planes) {
        ecp_i_put_int(t, "         planes_", i, ", ");
        ecp_i_put_int(t, "vertices_", i, ", NULL},\n");
    } else
        ecp_i_put(t, "         NULL, NULL, NULL},\n");
}

static void ecp_i_put_parts(const ecp_i_text *t, const ecp_world *w)
{
    int i;
    for (i = 0; i < w->shapes; i++) {
        const ecp_shape *s = &ecp_i_parts(w)[i].shape;
        if (!s->planes) continue;
        ecp_i_put_array(t, "planes_", i, s->planes, s->inequalities, 4);
        ecp_i_put_array(t, "vertices_", i, s->vertices, s->vertex_count, 3);
    }
    if (w->shapes == 0) return;
    ecp_i_put_int(t, "    static const ecp_i_part parts[", w->shapes, "] = {\n");
    for (i = 0; i < w->shapes; i++) {
        const ecp_i_part *p = ecp_i_parts(w) + i;
        ecp_i_put_int(t, "        {/* shape ", i, " */\n");
        ecp_i_put_shape(t, i, &p->shape);
        ecp_i_put(t, "         {\n");
        ecp_i_put_field(t, "mu", p->material.mu);
        ecp_i_put_field(t, "e_t", p->material.e_t);
        ecp_i_put_field(t, "e_o", p->material.e_o);
        ecp_i_put_field(t, "e_r", p->material.e_r);
        ecp_i_put_list(t, "direction", p->material.direction, 3, 3);
        ecp_i_put(t, "         },\n");
        ecp_i_put_list(t, "position", p->position, 3, 3);
        ecp_i_put_list(t, "rotation", p->rotation, 9, 3);
        ecp_i_put_list(t, "box_centre", p->box_centre, 3, 3);
        ecp_i_put_list(t, "box_half", p->box_half, 3, 3);
        ecp_i_put_int(t, "         ", p->body, ", /* body */\n         0x");
        ecp_i_put_digits(t, p->category, 16);
        ecp_i_put(t, "u, 0x");
        ecp_i_put_digits(t, p->collides_with, 16);
        ecp_i_put(t, "u},\n");
    }
    ecp_i_put(t, "    };\n");
}

static void ecp_i_put_contact(const ecp_i_text *t, const ecp_contact *c)
{
    static const char *const modes[3] = {"         ECP_APART},\n", "         ECP_STICK},\n",
                                         "         ECP_SLIP},\n"};
    ecp_i_put_int(t, "         {", c->shape_a, ", ");
    ecp_i_put_int(t, "", c->shape_b, ", /* shapes */\n");
    ecp_i_put_int(t, "         ", c->body_a, ", ");
    ecp_i_put_int(t, "", c->body_b, ", /* bodies */\n");
    ecp_i_put_list(t, "point_a", c->point_a, 3, 3);
    ecp_i_put_list(t, "point_b", c->point_b, 3, 3);
    ecp_i_put_list(t, "normal", c->normal, 3, 3);
    ecp_i_put_list(t, "direction_t", c->direction_t, 3, 3);
    ecp_i_put_list(t, "direction_o", c->direction_o, 3, 3);
    ecp_i_put_field(t, "gap", c->gap);
    ecp_i_put_field(t, "separation", c->separation);
    ecp_i_put_field(t, "p_n", c->p_n);
    ecp_i_put_field(t, "p_t", c->p_t);
    ecp_i_put_field(t, "p_o", c->p_o);
    ecp_i_put_field(t, "p_r", c->p_r);
    ecp_i_put_field(t, "sigma", c->sigma);
    ecp_i_put_field(t, "mu", c->mu);
    ecp_i_put_field(t, "e_t", c->e_t);
    ecp_i_put_field(t, "e_o", c->e_o);
    ecp_i_put_field(t, "e_r", c->e_r);
    ecp_i_put(t, modes[c->mode]);
}

static void ecp_i_put_patches(const ecp_i_text *t, const ecp_world *w)
{
    const ecp_i_part *parts = ecp_i_parts(w);
    int i, n, most = w->desc.max_inequalities;
    if (w->patches == 0) return;
    ecp_i_put_int(t, "    static const ecp_i_patch patches[", w->patches, "] = {\n");
    for (i = 0; i < w->patches; i++) {
        const ecp_i_patch *p = ecp_i_patches(w) + i;
        ecp_i_put_int(t, "        {/* patch ", i, " */\n");
        ecp_i_put_contact(t, &p->contact);
        ecp_i_put_list(t, "a", p->a, 3, 3);
        ecp_i_put_int(t, "         ", p->guess, ", ");
        ecp_i_put_int(t, "", p->centred, ", ");
        ecp_i_put_int(t, "", p->course, "}, /* guess, centred, course */\n");
    }
    ecp_i_put_int(t, "    };\n    static const ecp_real multipliers[", w->patches, "]");
    ecp_i_put_int(t, "[", most, "] = {\n");
    for (i = 0; i < w->patches; i++) {
        const ecp_contact *c = &ecp_i_patches(w)[i].contact;
        n = parts[c->shape_a].shape.inequalities + parts[c->shape_b].shape.inequalities;
        ecp_i_put_list(t, "multipliers of A and B", ecp_i_multipliers(w, i), n < most ? n : most,
                       4);
    }
    ecp_i_put(t, "    };\n");
}

static void ecp_i_put_world(const ecp_i_text *t, const ecp_world *w)
{
    int k;
    ecp_i_put(t, "    ecp_world_desc desc = ecp_world_desc_default();\n"
                 "    ecp_options options = ecp_options_default();\n"
                 "    ecp_world *w = NULL;\n"
                 "    ecp_status status;\n"
                 "    size_t bytes;\n");
    ecp_i_put_int(t, "    desc.max_bodies = ", w->desc.max_bodies, ";\n");
    ecp_i_put_int(t, "    desc.max_shapes = ", w->desc.max_shapes, ";\n");
    ecp_i_put_int(t, "    desc.max_patches = ", w->desc.max_patches, ";\n");
    ecp_i_put_int(t, "    desc.max_inequalities = ", w->desc.max_inequalities, ";\n");
    ecp_i_put_int(t, "    desc.advance_order = ", w->desc.advance_order, ";\n");
    ecp_i_put(t, "    desc.solver_bytes = ");
    ecp_i_put_size(t, w->desc.solver_bytes);
    ecp_i_put(t, ";\n");
    for (k = 0; k < 3; k++) {
        ecp_i_put_int(t, "    desc.gravity[", k, "] = ");
        ecp_i_put_real(t, w->desc.gravity[k]);
        ecp_i_put(t, ";\n");
    }
    ecp_i_put(t, "    bytes = ecp_world_memsize(&desc);\n"
                 "    status = ecp_world_init(&w, &desc, malloc(bytes), bytes);\n"
                 "    *world = w;\n"
                 "    if (status != ECP_OK) return status;\n");
    ecp_i_put_int(t, "    w->bodies = ", w->bodies, ";\n");
    ecp_i_put_int(t, "    w->shapes = ", w->shapes, ";\n");
    ecp_i_put_int(t, "    w->patches = ", w->patches, ";\n");
    ecp_i_put(t, "    w->last_h = ");
    ecp_i_put_real(t, w->last_h);
    ecp_i_put(t, ";\n    w->asked.tolerance = ");
    ecp_i_put_real(t, w->asked.tolerance);
    ecp_i_put_int(t, ";\n    w->asked.sleep = ", w->asked.sleep, ";\n");
    ecp_i_put_int(t, "    w->asked.rule = ", w->asked.rule, ";\n");
    ecp_i_put_int(t, "    w->asked.max_iterations = ", w->asked.max_iterations, ";\n");
    ecp_i_put_int(t, "    w->asked.max_total_iterations = ", w->asked.max_total_iterations, ";\n");
    ecp_i_put_int(t, "    w->asked.fallbacks = ", w->asked.fallbacks, ";\n");
    if (w->bodies > 0) ecp_i_put(t, "    memcpy(ecp_i_bodies(w), bodies, sizeof bodies);\n");
    if (w->shapes > 0) ecp_i_put(t, "    memcpy(ecp_i_parts(w), parts, sizeof parts);\n");
    if (w->patches > 0) {
        ecp_i_put(t, "    memcpy(ecp_i_patches(w), patches, sizeof patches);\n"
                     "    memcpy(ecp_i_multipliers(w, 0), multipliers, sizeof multipliers);\n");
    }
}

ECP_DEF ecp_status ecp_dump(const ecp_world *world, ecp_real h, const ecp_options *options,
                            void (*write)(void *user, const char *text), void *user)
{
    ecp_options o = ecp_options_default();
    ecp_i_text t;
    ecp_status status;
    int i;
    if (options) o = *options;
    status = world && write ? ecp_i_check_options(&o) : ECP_BAD_POINTER;
    if (status != ECP_OK) return status;
    if (!ecp_i_finite(h)) return ECP_NOT_FINITE;
    if (!(h > 0)) return ECP_BAD_STEP;
    if (world->advancing) return ECP_BAD_OPTION;
    t.write = write;
    t.user = user;
    ecp_i_put(
        &t, "/* A step, written by ecp_dump: to be compiled with the implementation of ecpsim.h,\n"
            "   <stdlib.h> and <string.h>");
    ecp_i_put(&t, sizeof h == sizeof(float) ? ", in float */\n" : " */\n");
    ecp_i_put(&t, "static ecp_status dumped_step(ecp_world **world, ecp_report *report)\n{\n");
    ecp_i_put_bodies(&t, world);
    ecp_i_put_parts(&t, world);
    ecp_i_put_patches(&t, world);
    ecp_i_put_world(&t, world);
    ecp_i_put(&t, o.rule == ECP_CENTRED ? "    options.rule = ECP_CENTRED;\n"
                                        : "    options.rule = ECP_NEAREST;\n");
    ecp_i_put(&t, "    options.tolerance = ");
    ecp_i_put_real(&t, o.tolerance);
    ecp_i_put_int(&t, ";\n    options.max_iterations = ", o.max_iterations, ";\n");
    ecp_i_put_int(&t, "    options.max_total_iterations = ", o.max_total_iterations, ";\n");
    ecp_i_put_int(&t, "    options.fallbacks = ", o.fallbacks, ";\n");
    if (o.sleep) ecp_i_put(&t, "    options.sleep = 1;\n");
    for (i = 0; i < world->shapes; i++) {
        if (ecp_i_parts(world)[i].shape.kind != ECP_CONVEX) continue;
        ecp_i_put_int(&t, "    return ECP_BAD_KIND; /* shape ", i,
                      " is of a class that cannot be written */\n");
        status = ECP_BAD_KIND;
    }
    ecp_i_put(&t, "    return ecp_step(w, ");
    ecp_i_put_real(&t, h);
    ecp_i_put(&t, ", &options, report);\n}\n");
    return status;
}

/* >>printed ===============================================================================
   The paper's equations, term by term as they are printed, on the states before and after a step.
   Nothing here is shared with the solver but the shapes, the vectors, the step of a quaternion, the momentum of a spin,
   and the gyroscopic moment of bodies that turn far within the step, which is not the printed one
   (ecp_i_gyroscopic). */

/* |residual| against the size of what it is made of */
static ecp_real ecp_i_relative(ecp_real residual, ecp_real size)
{
    return ecp_i_abs(residual) / ecp_i_max(size, ECP_I_SMALLEST);
}

/* 0 <= x _|_ y >= 0, each in its own unit: the natural residual min(x, y) */
static ecp_real ecp_i_complementarity(ecp_real x, ecp_real x_unit, ecp_real y, ecp_real y_unit)
{
    return ecp_i_abs(ecp_i_min(x / x_unit, y / y_unit));
}

typedef struct ecp_i_side {
    const ecp_i_body *after;
    const ecp_i_part *part;
    ecp_real Q[9], origin[3]; /* pose of the primitive after the step */
    ecp_real v[6];            /* velocity after the step */
} ecp_i_side;

static void ecp_i_side_setup(const ecp_world *after, int shape, ecp_i_side *s)
{
    ecp_real R[9];
    int k;
    s->part = ecp_i_parts(after) + shape;
    s->after = ecp_i_bodies(after) + s->part->body;
    ecp_quat_to_matrix(s->after->q, R);
    ecp_i_matmul(R, s->part->rotation, s->Q);
    ecp_i_mul(R, s->part->position, s->origin);
    ecp_i_add(s->origin, s->after->x, s->origin);
    ecp_i_add(s->origin, s->after->x_carry, s->origin);
    for (k = 0; k < 6; k++) s->v[k] = s->after->v[k] + s->after->v_carry[k];
}

/* velocity of the body at the point x */
static void ecp_i_side_velocity(const ecp_i_side *s, const ecp_real x[3], ecp_real v[3])
{
    ecp_real r[3];
    ecp_i_sub(x, s->after->x, r);
    ecp_i_copy3(s->v, v);
    ecp_i_add_cross(s->v + 3, r, v);
}

/* value of f_i at the world point x, and its gradient in world axes */
static void ecp_i_side_eval(const ecp_i_side *s, const ecp_real x[3], ecp_real *f, ecp_real *g,
                            int i, ecp_real *value, ecp_real gradient[3])
{
    ecp_real rel[3], local[3];
    ecp_i_sub(x, s->origin, rel);
    ecp_i_mul_t(s->Q, rel, local);
    s->part->shape.cls->eval(&s->part->shape, local, f, g);
    *value = f[i];
    ecp_i_mul(s->Q, g + 3 * i, gradient);
}

/* equation:friction and equation:friction_c of one patch */
static void ecp_i_printed_friction(const ecp_contact *k, const ecp_i_side *A, const ecp_i_side *B,
                                   ecp_real speed, ecp_real unit, ecp_printed *out)
{
    ecp_real va[3], vb[3], v[3], w[3], e[3], p[3], slip[3], cone, length, tight;
    int i;
    if (!(k->mu > 0)) return;
    ecp_i_side_velocity(A, k->point_a, va);
    ecp_i_side_velocity(B, k->point_a, vb);
    ecp_i_sub(va, vb, v);
    ecp_i_sub(A->v + 3, B->v + 3, w);
    ecp_i_set3(k->e_t, k->e_o, k->e_r, e);
    ecp_i_set3(k->p_t, k->p_o, k->p_r, p);
    ecp_i_set3(ecp_i_dot(k->direction_t, v), ecp_i_dot(k->direction_o, v), ecp_i_dot(k->normal, w),
               slip);
    cone = k->mu * k->mu * k->p_n * k->p_n;
    for (i = 0; i < 3; i++) {
        /* (a torsion has the scale of e_t, with its length) */
        length = i < 2 ? ECP_R(1) : ecp_i_max(k->e_r, ECP_I_EPSILON);
        tight = i < 2 ? e[i] : k->e_t;
        if (e[i] > 0) cone -= p[i] / e[i] * (p[i] / e[i]);
        ecp_i_worst(&out->friction,
                    ecp_i_relative(e[i] * e[i] * k->mu * k->p_n * slip[i] + p[i] * k->sigma,
                                   ecp_i_max(1, tight * tight) * length * unit * speed));
    }
    ecp_i_worst(&out->friction_c, ecp_i_complementarity(cone, unit * unit, k->sigma, speed));
}

/* equation:re_contact_multiple_1 to _5 of one patch. k1 is the constraint with the largest
   multiplier; the printed l_k1 is the gap times it, the other printed multipliers are ours divided
   by it. l: ours, those of A and then those of B (of a half-space: 1). */
static void ecp_i_printed_contact(const ecp_contact *k, const ecp_i_side *A, const ecp_i_side *B,
                                  const ecp_real *l, ecp_real *f, ecp_real *g, ecp_real speed,
                                  ecp_real h, ecp_real unit, ecp_printed *out)
{
    int nl = A->part->shape.inequalities, plane = B->part->shape.kind == ECP_HALF_SPACE;
    int nm = plane ? 1 : B->part->shape.inequalities, i, k1 = 0;
    ecp_real size = A->part->shape.radius, cone_a[3] = {0, 0, 0}, cone_b[3] = {0, 0, 0};
    ecp_real gradient[3], value, most = 0, l_k1, row[3], one = 1;
    for (i = 1; i < nl; i++) {
        if (l[i] > l[k1]) k1 = i;
    }
    l_k1 = k->gap * l[k1];
    for (i = 0; i < nl; i++) {
        ecp_real printed = i == k1 ? l_k1 : l[i] / l[k1];
        ecp_i_side_eval(A, k->point_a, f, g, i, &value, gradient);
        ecp_i_worst(&out->contact_3,
                    ecp_i_complementarity(printed, i == k1 ? size : one, -value, size));
        ecp_i_axpy(cone_a, i == k1 ? one : printed, gradient, cone_a);
        ecp_i_side_eval(A, k->point_b, f, g, i, &value, gradient);
        most = i ? ecp_i_max(most, value) : value;
    }
    for (i = 0; i < nm; i++) {
        ecp_real printed = (plane ? one : l[nl + i]) / l[k1];
        ecp_i_side_eval(B, k->point_b, f, g, i, &value, gradient);
        ecp_i_worst(&out->contact_4, ecp_i_complementarity(printed, 1, -value, size));
        ecp_i_axpy(cone_b, printed, gradient, cone_b);
    }
    for (i = 0; i < 3; i++) {
        row[i] = k->point_a[i] - k->point_b[i] + l_k1 * cone_a[i];
        ecp_i_worst(&out->contact_1, ecp_i_relative(row[i], size));
        ecp_i_worst(&out->contact_2, ecp_i_relative(cone_a[i] + cone_b[i], 1 / l[k1]));
    }
    ecp_i_worst(&out->contact_5, ecp_i_complementarity(k->p_n, unit, most, h * speed));
}

/* equ:discrete_NE and equ:kinematic of one body; wrench: sum of W p */
static void ecp_i_printed_body(const ecp_world *before, const ecp_world *after, int i, ecp_real h,
                               const ecp_real wrench[6], ecp_real speed, ecp_printed *out)
{
    const ecp_i_body *b = ecp_i_bodies(before) + i, *a = ecp_i_bodies(after) + i;
    ecp_real R[9], inertia[9], change[6], Iw[3], gyro[3], moved[3], q[4], v[6];
    int k;
    for (k = 0; k < 6; k++) {
        v[k] = a->v[k] + a->v_carry[k];
        change[k] = (a->v[k] - b->v[k]) + (a->v_carry[k] - b->v_carry[k]);
    }
    if (b->kind == ECP_DYNAMIC) {
        ecp_real unit = b->mass * speed;
        ecp_quat_to_matrix(b->q, R);
        ecp_i_congruence(R, b->inertia, inertia);
        ecp_i_gyroscopic(inertia, b->v + 3, h, gyro);
        ecp_i_spin_momentum(R, b->inertia, change + 3, Iw);
        for (k = 0; k < 3; k++) {
            ecp_real app = h * (b->mass * before->desc.gravity[k] + b->force[k]) + b->impulse[k];
            ecp_real torque = h * (b->force[3 + k] - gyro[k]) + b->impulse[3 + k];
            ecp_i_worst(&out->newton_euler,
                        ecp_i_relative(b->mass * change[k] - wrench[k] - app, unit));
            ecp_i_worst(&out->newton_euler,
                        ecp_i_relative(Iw[k] - wrench[3 + k] - torque, unit * b->length));
        }
    }
    if (b->kind == ECP_STATIC || b->kind == ECP_I_FREE) return;
    ecp_quat_advance(b->q, v + 3, h, q);
    for (k = 0; k < 4; k++) {
        ecp_real carried = b->q_carry[k] - a->q_carry[k];
        ecp_i_worst(&out->kinematic, ecp_i_abs((q[k] - a->q[k]) + carried));
    }
    for (k = 0; k < 3; k++) {
        moved[k] = (a->x[k] - b->x[k]) + (a->x_carry[k] - b->x_carry[k]);
        ecp_i_worst(&out->kinematic, ecp_i_relative(moved[k] - h * v[k], h * speed));
    }
}

/* W p of all patches on body i */
static void ecp_i_printed_wrench(const ecp_world *after, int body, ecp_real wrench[6])
{
    int i, k;
    for (k = 0; k < 6; k++) wrench[k] = 0;
    for (i = 0; i < after->patches; i++) {
        const ecp_contact *c = &ecp_i_patches(after)[i].contact;
        ecp_real force[3], r[3], sign = c->body_a == body ? ECP_R(1) : ECP_R(-1);
        if (ecp_i_patches(after)[i].guess || (c->body_a != body && c->body_b != body)) continue;
        ecp_i_scale(sign * c->p_n, c->normal, force);
        ecp_i_axpy(force, sign * c->p_t, c->direction_t, force);
        ecp_i_axpy(force, sign * c->p_o, c->direction_o, force);
        ecp_i_sub(c->point_a, ecp_i_bodies(after)[body].x, r);
        ecp_i_add(wrench, force, wrench);
        ecp_i_add_cross(r, force, wrench + 3);
        ecp_i_axpy(wrench + 3, sign * c->p_r, c->normal, wrench + 3);
    }
}

/* the speed that residuals are measured by: the fastest motion before and after the step, or g h */
static ecp_real ecp_i_printed_speed(const ecp_world *before, const ecp_world *after, ecp_real h)
{
    ecp_real speed = h * ecp_i_norm(before->desc.gravity), least = 0;
    int i, k;
    for (i = 0; i < before->bodies; i++) {
        const ecp_i_body *b[2];
        b[0] = ecp_i_bodies(before) + i;
        b[1] = ecp_i_bodies(after) + i;
        for (k = 0; k < 2; k++) {
            speed = ecp_i_max(speed, ecp_i_norm(b[k]->v));
            speed = ecp_i_max(speed, b[k]->length * ecp_i_norm(b[k]->v + 3));
        }
        least = ecp_i_max(least, 64 * ECP_I_EPSILON * b[0]->length / h);
    }
    return ecp_i_max(speed, least);
}

/* the most inequalities that the printed equations are evaluated for at once */
#define ECP_I_PRINTED_INEQUALITIES 64

ECP_DEF ecp_status ecp_printed_residual(const ecp_world *before, const ecp_world *after, ecp_real h,
                                        ecp_printed *printed)
{
    ecp_real f[ECP_I_PRINTED_INEQUALITIES], g[3 * ECP_I_PRINTED_INEQUALITIES], wrench[6], speed;
    ecp_real all[9];
    int i;
    if (!before || !after || !printed) return ECP_BAD_POINTER;
    if (!ecp_i_finite(h)) return ECP_NOT_FINITE;
    if (!(h > 0)) return ECP_BAD_STEP;
    if (before->bodies != after->bodies || before->shapes != after->shapes) return ECP_BAD_INDEX;
    if (after->desc.max_inequalities > ECP_I_PRINTED_INEQUALITIES) return ECP_CAPACITY;
    ECPSIM_MEMSET(printed, 0, sizeof *printed);
    speed = ecp_i_printed_speed(before, after, h);
    for (i = 0; i < after->bodies; i++) {
        ecp_i_printed_wrench(after, i, wrench);
        ecp_i_printed_body(before, after, i, h, wrench, speed, printed);
    }
    for (i = 0; i < after->patches; i++) {
        const ecp_contact *k = &ecp_i_patches(after)[i].contact;
        ecp_i_side A, B;
        ecp_real unit;
        if (ecp_i_patches(after)[i].guess) continue;
        ecp_i_side_setup(after, k->shape_a, &A);
        ecp_i_side_setup(after, k->shape_b, &B);
        unit = speed * ecp_i_max(A.after->mass, B.after->mass);
        ecp_i_printed_friction(k, &A, &B, speed, unit, printed);
        ecp_i_printed_contact(k, &A, &B, ecp_i_multipliers(after, i), f, g, speed, h, unit,
                              printed);
    }
    all[0] = printed->newton_euler;
    all[1] = printed->kinematic;
    all[2] = printed->friction;
    all[3] = printed->friction_c;
    all[4] = printed->contact_1;
    all[5] = printed->contact_2;
    all[6] = printed->contact_3;
    all[7] = printed->contact_4;
    all[8] = printed->contact_5;
    for (i = 0; i < 9; i++) ecp_i_worst(&printed->largest, all[i]);
    return ECP_OK;
}

/* >>translation: the closed form. With N = max(0, -n.J - m n.v) for the sum of the normal impulses
   and T = (m v + J) without its normal part, friction is -e mu N T / |T| while |T| > e mu N (slip),
   else -T (stick). */
ECP_DEF ecp_mode ecp_translation_step(ecp_real mass, const ecp_real normal[3], ecp_real mu,
                                      ecp_real e, const ecp_real J[3], const ecp_real v[3],
                                      ecp_real v_out[3], ecp_real impulse[3])
{
    ecp_real momentum[3], T[3], along, N, size, friction;
    ecp_mode mode = ECP_STICK;
    ecp_i_axpy(J, mass, v, momentum);
    along = ecp_i_dot(normal, momentum);
    N = ecp_i_max(0, -along);
    ecp_i_axpy(momentum, -along, normal, T);
    size = ecp_i_norm(T);
    friction = ecp_i_min(size, e * mu * N);
    if (size > friction) mode = ECP_SLIP;
    if (along > 0) mode = ECP_APART;
    ecp_i_scale(N, normal, impulse);
    if (size > 0) ecp_i_axpy(impulse, -friction / size, T, impulse);
    ecp_i_add(momentum, impulse, momentum);
    ecp_i_scale(1 / mass, momentum, v_out);
    return mode;
}

#ifdef __cplusplus
}
#endif

#endif /* ECPSIM_IMPLEMENTED */
#endif /* ECPSIM_IMPLEMENTATION */

/* >>licence ===============================================================================
   This software is available under two licences; choose whichever you prefer.

   ALTERNATIVE A - MIT License
   Copyright (c) 2026 the ecpsim authors
   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and
   associated documentation files (the "Software"), to deal in the Software without restriction,
   including without limitation the rights to use, copy, modify, merge, publish, distribute,
   sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is
   furnished to do so, subject to the following conditions: The above copyright notice and this
   permission notice shall be included in all copies or substantial portions of the Software.
   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT
   NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
   NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM,
   DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT
   OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

   ALTERNATIVE B - Public Domain (www.unlicense.org)
   This is free and unencumbered software released into the public domain. Anyone is free to copy,
   modify, publish, use, compile, sell, or distribute this software, either in source code form or
   as a compiled binary, for any purpose, commercial or non-commercial, and by any means. In
   jurisdictions that recognize copyright laws, the author or authors of this software dedicate any
   and all copyright interest in the software to the public domain. We make this dedication for the
   benefit of the public at large and to the detriment of our heirs and successors. We intend this
   dedication to be an overt act of relinquishment in perpetuity of all present and future rights to
   this software under copyright law.
   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT
   NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
   NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
   LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN
   CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
